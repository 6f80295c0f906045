#include <equistream_client/specular.h>

#include "eye_rays.h"
#include "source_lookup.h"
#include "specular_sample.h"

#include "../fill/sample_grid.h"

#include <equistream/bound.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>

namespace equistream {

namespace {

constexpr int most_steps = 24;

Vec3f operator-(Vec3f a, Vec3f b) {
    return a + b * -1;
}

template <typename Lookup>
class SpecularRework {
public:
    SpecularRework(const Lookup& lookup, const SourceView& source, const EyeView& eye, double budget_rad)
        : lookup_(lookup), source_(source), grid_(source),
          rays_(eye.camera, eye.pose, source.pose), agreement_{std::max(float(source.box_radius_m), rays_.distance_m()),
                                                               float(std::sin(budget_rad))},
          width_(width_of(source.camera)), height_(height_of(source.camera)) {}

    enum class Answer { untouched, kept, by_image, gap };

    /// `depth_m`: of what the eye's pixel shows.
    Answer rework(int x, int y, float depth_m, std::uint8_t* rgba) const {
        if (!(depth_m > 0))
            return Answer::untouched;
        const float length = rays_.length(x, y);
        const Vec3f ray = rays_.direction(x, y) * (1 / length);
        const SpecularSample surface =
            sample(lookup_.project(rays_.eye() * (1 / std::min(depth_m, far_distance_m)) + ray));
        if (!surface.specular)
            return Answer::untouched;
        const float image_m = image_distance(source_, surface);
        if (warps_with_surface(agreement_, source_.depth_m.pixel(surface.x, surface.y)[0], image_m))
            return Answer::kept;
        if (std::isnan(image_m))
            return Answer::gap;
        float nearest_m = std::numeric_limits<float>::infinity();
        PixelPosition found;
        for (const float start_m : {image_m, std::min(depth_m, far_distance_m), far_distance_m}) {
            PixelPosition position;
            const float distance_m = follow(ray, start_m, position);
            if (distance_m < nearest_m) {
                nearest_m = distance_m;
                found = position;
            }
        }
        return std::isfinite(nearest_m) && mix(found, rgba) ? Answer::by_image : Answer::gap;
    }

private:
    float w(float distance_m) const { return agreement_.box_radius_m / agreement_.reach(distance_m); }

    /// The one nearest to a position.
    SpecularSample sample(PixelPosition p) const {
        if (!lookup_.contains(p))
            return {};
        return specular_sample(source_, std::clamp(int(p.u), 0, width_ - 1), std::clamp(int(p.v), 0, height_ - 1));
    }

    /// From a distance along the eye's ray to the image that the source has in that direction, to the ray's point
    /// nearest to it, and so on: until the image lies on the ray. Returns how far away that is; +inf where it leads
    /// nowhere.
    float follow(Vec3f ray, float distance_m, PixelPosition& position) const {
        for (int step = 0; step < most_steps; ++step) {
            const Vec3f point = rays_.eye() + ray * distance_m;
            position = lookup_.project(point);
            const SpecularSample seen = sample(position);
            const float image_m = seen.specular ? image_distance(source_, seen) : std::nanf("");
            if (std::isnan(image_m))
                return std::numeric_limits<float>::infinity();
            const Vec3f image = point * (image_m / std::sqrt(dot(point, point)));
            const Vec3f from_eye = image - rays_.eye();
            const float next_m = dot(from_eye, ray);
            if (!(next_m > 0))
                return std::numeric_limits<float>::infinity();
            const Vec3f beside = from_eye - ray * next_m;
            if (std::sqrt(dot(beside, beside)) <= agreement_.tolerance * next_m)
                return next_m;
            distance_m = next_m;
        }
        return std::numeric_limits<float>::infinity();
    }

    /// Of the four samples around, those that show the same image.
    bool mix(PixelPosition position, std::uint8_t* rgba) const {
        const Taps taps = lookup_.taps(position);
        const float w_found = w(image_distance(source_, sample(position)));
        float sum = 0;
        Vec3f colour;
        for (int k = 0; k < 4; ++k) {
            const SpecularSample tap = specular_sample(source_, taps.x[k], taps.y[k]);
            const float image_m = tap.specular ? image_distance(source_, tap) : std::nanf("");
            if (!(std::abs(w(image_m) - w_found) <= agreement_.tolerance))
                continue;
            sum += taps.weight[k];
            colour = colour + grid_.colour({tap.x, tap.y}) * taps.weight[k];
        }
        if (!(sum > 0))
            return false;
        rgba[0] = std::uint8_t(colour.x / sum + 0.5f);
        rgba[1] = std::uint8_t(colour.y / sum + 0.5f);
        rgba[2] = std::uint8_t(colour.z / sum + 0.5f);
        return true;
    }

    const Lookup& lookup_;
    const SourceView& source_;
    PictureGrid grid_;
    EyeRays rays_;
    DepthAgreement agreement_;
    int width_, height_;
};

template <typename Lookup>
SpecularCounts rework_all(const SpecularRework<Lookup>& rework, ImageView<const float> depth_m, EyePicture& picture) {
    using Answer = typename SpecularRework<Lookup>::Answer;
    SpecularCounts total;
    std::mutex mutex;
    tbb::parallel_for(tbb::blocked_range<int>(0, depth_m.height, 8), [&](const tbb::blocked_range<int>& rows) {
        SpecularCounts counts;
        for (int y = rows.begin(); y < rows.end(); ++y)
            for (int x = 0; x < depth_m.width; ++x) {
                std::uint8_t* origin = picture.origin.pixel(x, y);
                if (*origin != std::uint8_t(PixelOrigin::source))
                    continue;
                const Answer answer = rework.rework(x, y, *depth_m.pixel(x, y), picture.rgba.pixel(x, y));
                counts.kept += answer == Answer::kept;
                counts.by_image += answer == Answer::by_image;
                if (answer != Answer::gap)
                    continue;
                ++counts.gaps;
                *origin = std::uint8_t(PixelOrigin::gap);
                std::fill_n(picture.rgba.pixel(x, y), 4, std::uint8_t{0});
                if (!picture.depth_m.empty())
                    *picture.depth_m.pixel(x, y) = std::nanf("");
            }
        const std::scoped_lock lock(mutex);
        total = {total.kept + counts.kept, total.by_image + counts.by_image, total.gaps + counts.gaps};
    });
    return total;
}

}  // namespace

SpecularCounts rework_specular(const SourceView& source, const EyeView& eye, double error_budget_px,
                               EyePicture& picture) {
    const bool own = eye.depth_m.data == nullptr && !picture.depth_m.empty();
    const ImageView<const float> depth_m = own ? picture.depth_m.view() : eye.depth_m;
    if (source.specular.data == nullptr || source.depth_m.data == nullptr || depth_m.data == nullptr)
        return {};
    const double budget_rad = 4 * error_budget_px * error_budget_rad(eye.camera.focal_px());
    const auto run = [&](const auto& lookup) {
        return rework_all(SpecularRework(lookup, source, eye, budget_rad), depth_m, picture);
    };
    if (const auto* sphere = std::get_if<EquirectCamera>(&source.camera))
        return run(EquirectLookup(*sphere));
    return run(PerspectiveLookup(std::get<PerspectiveCamera>(source.camera)));
}

}  // namespace equistream
