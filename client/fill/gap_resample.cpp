#include "gap_resample.h"

#include <client/reflections/specular.h>
#include <client/warp/eye_rays.h>
#include <client/warp/resample.h>

#include <equistream/bound.h>
#include <equistream/depth_agreement.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>

namespace equistream {

namespace {

/// The four samples around a position that the picture holds; the others have weight 0.
struct Neighbourhood {
    Taps taps;
    std::array<SamplePlace, 4> places{};
};

/// As DepthAgreement has it.
float tolerance_of(const GapResampleTask& task) {
    return float(std::sin(error_budget_rad(task.eye.camera.focal_px(), task.error_budget_px)));
}

/// Where a grid has what a gap pixel sees.
template <typename Grid>
class PointSamples {
public:
    PointSamples(const Grid& grid, const GapResampleTask& task)
        : grid_(grid), lookup_(grid.camera()), task_(task), rays_(task.eye.camera, task.eye.pose, grid.pose()),
          agreement_{std::max(float(grid.box_radius_m()), rays_.distance_m()), tolerance_of(task)} {}

    /// Samples of the surface that the pixel sees: false if there are too few.
    bool of_surface(int x, int y, Neighbourhood& around) const {
        const FloatImage& inverse_planar = task_.seen.inverse_planar;
        const float inverse = inverse_planar.pixel(x, y)[0];
        if (!(inverse >= 0))
            return false;
        const glm::vec3 d = rays_.direction(x, y) + rays_.eye() * inverse;
        const PixelPosition position = lookup_.project(d);
        if (!lookup_.contains(position) || !find(position, around))
            return false;
        if (rays_.shows_back_to_source(inverse_planar, x, y))
            return false;
        const float clearance = agreement_.clearance(std::sqrt(dot(d, d)) / inverse);
        const bool all = keep_same_surface(around, clearance, x, y);
        if (!enough(around) || (!all && hidden(position, 1 / clearance)))
            return false;
        if (!task_.unmixed_only)
            return true;
        for (int k = 0; k < 4; ++k)
            if (around.taps.weight[k] != 0 && is_mixed(around.taps.x[k], around.taps.y[k], around.places[k]))
                around.taps.weight[k] = 0;
        return enough(around);
    }

    bool in_direction(int x, int y, Neighbourhood& around) const {
        const PixelPosition position = lookup_.project(rays_.direction(x, y));
        return lookup_.contains(position) && find(position, around) && enough(around);
    }

    void mix(const Neighbourhood& around, std::uint8_t* rgba) const {
        float sum = 0;
        glm::vec3 colour(0);
        for (int k = 0; k < 4; ++k) {
            const float weight = around.taps.weight[k];
            if (weight == 0)
                continue;
            sum += weight;
            colour = colour + grid_.colour(around.places[k]) * weight;
        }
        rgba[0] = std::uint8_t(colour.x / sum + 0.5f);
        rgba[1] = std::uint8_t(colour.y / sum + 0.5f);
        rgba[2] = std::uint8_t(colour.z / sum + 0.5f);
        rgba[3] = 255;
    }

    /// Of the pixel's point, from the grid's centre; 0 at infinity.
    float inverse_distance(int x, int y) const {
        const float inverse = task_.seen.inverse_planar.pixel(x, y)[0];
        const glm::vec3 d = rays_.direction(x, y) + rays_.eye() * inverse;
        return inverse / std::sqrt(dot(d, d));
    }
    float eye_distance_m() const { return rays_.distance_m(); }

private:
    static bool enough(const Neighbourhood& around) {
        const auto& w = around.taps.weight;
        return w[0] + w[1] + w[2] + w[3] > min_weight;
    }

    bool find(PixelPosition position, Neighbourhood& around) const {
        around.taps = lookup_.taps(position);
        bool any = false;
        for (int k = 0; k < 4; ++k) {
            const bool there = grid_.find(around.taps.x[k], around.taps.y[k], around.places[k]);
            any |= there;
            if (!there)
                around.taps.weight[k] = 0;
        }
        return any;
    }

    /// The rule of depth_agreement.h, as the engines have it. They apply it to whole registers of samples that lie side
    /// by side (warp_surface_kernels.cpp); here pixels and the samples that a grid holds are scattered, few need the
    /// plane, and gathering them into registers would cost more than it saves. A test holds the two to one another.
    /// Returns whether all four stay.
    bool keep_same_surface(Neighbourhood& around, float clearance, int x, int y) const {
        bool sloped = false, all = true;
        glm::vec3 gradient(0);
        for (int k = 0; k < 4; ++k) {
            all = all && around.taps.weight[k] != 0;
            if (around.taps.weight[k] == 0)
                continue;
            const float clearance_sample = agreement_.clearance(grid_.depth_m(around.places[k]));
            if (agreement_.same(clearance, clearance_sample))
                continue;
            if (!sloped)
                gradient = rays_.inverse_distance_gradient(task_.seen.inverse_planar, x, y);
            sloped = true;
            const float inverse = dot(gradient, lookup_.unit_direction(around.taps.x[k], around.taps.y[k]));
            const float predicted = inverse > 1 / far_distance_m ? 1 / inverse : far_distance_m;
            if (!agreement_.between(clearance, agreement_.clearance(predicted), clearance_sample)) {
                around.taps.weight[k] = 0;
                all = false;
            }
        }
        return all;
    }

    /// Whether the grid's surface runs before a point at this position (resample.h). Beyond rows, and where a
    /// grid has nothing, nothing hides: patches end anywhere.
    bool hidden(PixelPosition position, float point_over_clearance) const {
        const BilinearCell cell(position);
        std::array<float, 16> over_clearance;
        for (int i = 0; i < 16; ++i)
            over_clearance[std::size_t(i)] =
                1 / agreement_.clearance(1 / inverse_at(cell.x - 1 + i % 4, cell.y - 1 + i / 4));
        return surface_hides(agreement_, over_clearance, position.u - 0.5f - float(cell.x),
                             position.v - 0.5f - float(cell.y), point_over_clearance);
    }

    /// Whether something nearer begins beside a sample: its colour, filtered over the pixel, has a share in it. What a
    /// slope explains is the same surface.
    bool is_mixed(int x, int y, SamplePlace place) const {
        const float own = inverse(grid_.depth_m(place));
        for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
            const float beside = inverse_at(x + dx, y + dy);
            if (!(beside > own) || agreement_.same_inverse(own, beside))
                continue;
            const float behind = inverse_at(x - dx, y - dy);
            if (!agreement_.same_inverse(2 * own - behind, beside))
                return true;
        }
        return false;
    }
    static float inverse(float depth_m) { return 1 / std::min(depth_m, far_distance_m); }
    /// NaN where the grid has nothing.
    float inverse_at(int x, int y) const {
        const formulas::Wrapping& wrapping = lookup_.grid();
        x = formulas::column_round(wrapping, x);
        SamplePlace place;
        if (x < 0 || y < 0 || x >= wrapping.width || y >= wrapping.height || !grid_.find(x, y, place))
            return std::nanf("");
        return inverse(grid_.depth_m(place));
    }

    const Grid& grid_;
    SourceLookup lookup_;
    const GapResampleTask& task_;
    EyeRays rays_;
    DepthAgreement agreement_;
};

/// What one picture's mask and virtual depths say of the surfaces that it sees.
class Mirrors {
public:
    Mirrors(const SourceView& view, const GapResampleTask& task)
        : view_(view), grid_(view), task_{task.eye, task.seen, task.gaps, task.error_budget_px}, samples_(grid_, task_),
          tolerance_(tolerance_of(task)) {}

    /// Whether samples taken from some place have what the eye sees at a pixel, which may be an image. That lies as far
    /// behind the surface as the mask's picture says: from places near each other nearly the same.
    template <typename Samples>
    bool show_the_same(const Samples& taken, int x, int y) const {
        Neighbourhood around;
        if (!samples_.of_surface(x, y, around))
            return true;
        const auto& weight = around.taps.weight;
        const auto k = std::size_t(std::max_element(weight.begin(), weight.end()) - weight.begin());
        const SpecularSample sample = specular_sample(view_, around.taps.x[k], around.taps.y[k]);
        if (!sample.specular)
            return true;
        const float surface_m = std::min(1 / taken.inverse_distance(x, y), far_distance_m);
        const float behind_m = image_distance(view_, sample) - view_.depth_m.pixel(sample.x, sample.y)[0];
        return warps_with_surface({taken.eye_distance_m(), tolerance_}, surface_m, surface_m + behind_m);
    }

private:
    const SourceView& view_;
    PictureGrid grid_;
    GapResampleTask task_;  ///< where mirrors are any sample tells, of mixed colour too
    PointSamples<PictureGrid> samples_;
    float tolerance_;
};

/// Runs colour_pixel(x, y, rgba) -> coloured? for every gap that is still open, on all cores.
template <typename ColourPixel>
std::int64_t over_gaps(const GapResampleTask& task, EyePicture& picture, const ColourPixel& colour_pixel) {
    std::atomic<std::int64_t> total{0};
    const std::span<const GapSpan> spans = task.gaps.spans();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, spans.size(), 64), [&](const auto& range) {
        std::int64_t coloured = 0;
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            for (int x = spans[i].begin, y = spans[i].y; x < spans[i].end; ++x) {
                std::uint8_t* origin = picture.origin.pixel(x, y);
                if (*origin != std::uint8_t(PixelOrigin::gap) || !colour_pixel(x, y, picture.rgba.pixel(x, y)))
                    continue;
                *origin = std::uint8_t(task.mark);
                ++coloured;
            }
        total += coloured;
    });
    return total;
}

bool tells_of_mirrors(const SourceView* view) {
    return view != nullptr && view->specular.data != nullptr && view->depth_m.data != nullptr;
}

template <typename Grid>
std::int64_t by_surface(const Grid& grid, const SourceView* own, const GapResampleTask& task, EyePicture& picture) {
    const SourceView* teller = tells_of_mirrors(own) ? own : task.main;
    const PointSamples samples(grid, task);
    std::optional<Mirrors> mirrors;
    if (tells_of_mirrors(teller))
        mirrors.emplace(*teller, task);
    return over_gaps(task, picture, [&](int x, int y, std::uint8_t* rgba) {
        Neighbourhood around;
        if (!samples.of_surface(x, y, around) || (mirrors && !mirrors->show_the_same(samples, x, y)) ||
            (task.is_outdated && task.is_outdated(x, y)))
            return false;
        samples.mix(around, rgba);
        // By direction nothing tells how far it is: depth stays NaN there.
        if (!picture.depth_m.empty())
            picture.depth_m.pixel(x, y)[0] =
                radial_over_planar(task.eye.camera, x, y) / task.seen.inverse_planar.pixel(x, y)[0];
        return true;
    });
}

}  // namespace

std::int64_t resample_gaps(const PictureGrid& grid, const GapResampleTask& task, EyePicture& picture) {
    return by_surface(grid, &grid.view(), task, picture);
}

std::int64_t resample_gaps(const PatchGrid& grid, const GapResampleTask& task, EyePicture& picture) {
    return by_surface(grid, nullptr, task, picture);
}

std::int64_t resample_gaps_by_direction(const PictureGrid& grid, const GapResampleTask& task, EyePicture& picture) {
    const PointSamples samples(grid, task);
    return over_gaps(task, picture, [&](int x, int y, std::uint8_t* rgba) {
        Neighbourhood around;
        if (!samples.in_direction(x, y, around))
            return false;
        samples.mix(around, rgba);
        return true;
    });
}

}  // namespace equistream
