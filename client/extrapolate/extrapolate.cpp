#include "extrapolate.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace equistream {
namespace {

constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
constexpr int no_region = -1;

/// An 8-bit picture of any kind as RGB of its own.
void copy_rgb(const ReceivedPicture& from, ByteImage& to) {
    const int width = from.width(), height = from.height();
    if (to.width() != width || to.height() != height || to.channels() != 3)
        to = ByteImage(width, height, 3);
    tbb::parallel_for(0, height, [&](int y) {
        std::uint8_t* out = to.view().row(y);
        for (int x = 0; x < width; ++x, out += 3)
            if (from.yuv.empty())
                std::copy_n(from.rgb.pixel(x, y), 3, out);
            else
                std::ranges::copy(yuv_to_rgb::rgb_at(from.yuv.planes, x, y), out);
    });
}

/// One picture's extrapolating.
class Extrapolation {
public:
    Extrapolation(const ReceivedPicture& from, const FloatImage& depth_m, ExtrapolatedPicture& to)
        : from_(from), depth_m_(depth_m), to_(to), width_(from.width()) {
        copy_rgb(from, to.picture.rgb);
        to.picture.info = from.info;
        to.picture.specular = from.specular;
        to.picture.virtual_depth_m = from.virtual_depth_m;
        to.depth_m = depth_m;
        to.moved_pixels = to.uncovered_pixels = 0;
    }

    std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width_) + std::size_t(x); }
    float region_depth_m(const MovingRegion& region, int x, int y) const {
        const float r = *depth_m_.pixel(x, y);
        return std::isnan(r) ? r : std::clamp(r, region.near_m, region.far_m);
    }

    /// What stands at pixel (x, y) after the region there was moved to it, if anything: `was` says where it was.
    void show(int x, int y, const MovedRegion& region, glm::dvec2 was, const std::vector<int>& regions, int number) {
        const int sx = int(std::floor(was.x)), sy = int(std::floor(was.y));
        const float before_m = region_depth_m(region.region(), sx, sy);
        const auto now_m = float(region.distance_after_m(was, before_m));
        const bool rests = regions[index(x, y)] == no_region;
        // What rests there and is nearer; infinity and NaN are not.
        if (rests && *depth_m_.pixel(x, y) <= now_m)
            return;
        std::array<double, 3> sum{};
        double weights = 0;
        for (const auto& [tap_x, tap_y, weight] : region.taps(was))
            if (regions[index(tap_x, tap_y)] == number) {
                const std::array<std::uint8_t, 3> rgb = colour(tap_x, tap_y);
                for (int c = 0; c < 3; ++c)
                    sum[c] += weight * rgb[c];
                weights += weight;
            }
        for (int c = 0; c < 3; ++c)
            to_.picture.rgb.pixel(x, y)[c] = std::uint8_t(std::lround(sum[c] / weights));
        *to_.depth_m.pixel(x, y) = now_m;
        if (!from_.specular.empty())
            *to_.picture.specular.pixel(x, y) = *from_.specular.pixel(sx, sy);
        if (!from_.virtual_depth_m.empty())
            *to_.picture.virtual_depth_m.pixel(x, y) = *from_.virtual_depth_m.pixel(sx, sy) + now_m - before_m;
        ++to_.moved_pixels;
    }

    void uncover(const MovingRegion& region) {
        for (const PixelRun& run : region.runs)
            std::fill(to_.depth_m.pixel(run.begin, run.row),
                      to_.depth_m.pixel(run.begin, run.row) + (run.end - run.begin), nothing);
    }
    void count_uncovered(const MovingRegion& region) {
        for (const PixelRun& run : region.runs)
            to_.uncovered_pixels += std::count_if(to_.depth_m.pixel(run.begin, run.row),
                                                  to_.depth_m.pixel(run.begin, run.row) + (run.end - run.begin),
                                                  [](float r) { return std::isnan(r); });
    }

private:
    std::array<std::uint8_t, 3> colour(int x, int y) const {
        if (!from_.yuv.empty())
            return yuv_to_rgb::rgb_at(from_.yuv.planes, x, y);
        const std::uint8_t* rgb = from_.rgb.pixel(x, y);
        return {rgb[0], rgb[1], rgb[2]};
    }

    const ReceivedPicture& from_;
    const FloatImage& depth_m_;
    ExtrapolatedPicture& to_;
    int width_;
};

}  // namespace

bool can_extrapolate(const ReceivedPicture& picture, double seconds) {
    return seconds > 0 && !picture.info.moving.empty();
}

void PictureExtrapolator::extrapolate(const ReceivedPicture& picture, const FloatImage& depth_m, double seconds,
                                      ExtrapolatedPicture& extrapolated) {
    const int width = picture.width(), height = picture.height();
    assert(depth_m.width() == width && depth_m.height() == height);
    Extrapolation extrapolation(picture, depth_m, extrapolated);
    const std::size_t pixels = std::size_t(width) * std::size_t(height);
    if (region_.size() != pixels) {
        region_.assign(pixels, no_region);
        candidates_.assign(pixels, {std::numeric_limits<float>::infinity(), no_region});
        reached_.clear();
    }
    const std::vector<MovingRegion>& regions = picture.info.moving;
    std::vector<MovedRegion> moved;
    for (const MovingRegion& region : regions)
        moved.emplace_back(region, picture.info, seconds);
    for (std::size_t k = 0; k < regions.size(); ++k) {
        for (const PixelRun& run : regions[k].runs)
            std::fill_n(region_.begin() + std::ptrdiff_t(extrapolation.index(run.begin, run.row)), run.end - run.begin,
                        int(k));
        extrapolation.uncover(regions[k]);
    }
    for (std::size_t k = 0; k < regions.size(); ++k)
        for (const PixelRun& run : regions[k].runs)
            for (int x = run.begin; x < run.end; ++x)
                moved[k].splat(x, run.row, extrapolation.region_depth_m(regions[k], x, run.row),
                               [&](int to_x, int to_y, float r) {
                                   Candidate& candidate = candidates_[extrapolation.index(to_x, to_y)];
                                   if (candidate.region == no_region)
                                       reached_.push_back(extrapolation.index(to_x, to_y));
                                   if (r < candidate.distance_m)
                                       candidate = {r, int(k)};
                               });
    for (const std::size_t i : reached_) {
        const int x = int(i % std::size_t(width)), y = int(i / std::size_t(width));
        Candidate& candidate = candidates_[i];
        const MovedRegion& region = moved[std::size_t(candidate.region)];
        // A splat is wider than a pixel: only what was in the region is shown.
        if (const auto was = region.before(x, y, candidate.distance_m);
            was && region_[extrapolation.index(int(std::floor(was->x)), int(std::floor(was->y)))] == candidate.region)
            extrapolation.show(x, y, region, *was, region_, candidate.region);
        candidate = {std::numeric_limits<float>::infinity(), no_region};
    }
    reached_.clear();
    for (const MovingRegion& region : regions) {
        extrapolation.count_uncovered(region);
        for (const PixelRun& run : region.runs)
            std::fill_n(region_.begin() + std::ptrdiff_t(extrapolation.index(run.begin, run.row)), run.end - run.begin,
                        no_region);
    }
}

}  // namespace equistream
