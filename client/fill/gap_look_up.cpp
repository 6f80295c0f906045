#include "gap_look_up.h"

#include "../reproject/eye_rays.h"
#include "../reproject/source_lookup.h"

#include <equistream/bound.h>
#include <equistream/depth_agreement.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <array>
#include <atomic>

namespace equistream {

namespace {

/// As for the engines: below this share of the four samples' weight what is left lies too far to one side.
constexpr float least_weight = 0.1f;

/// The four samples around a position that the picture holds; the others have weight 0.
struct Neighbourhood {
    Taps taps;
    std::array<SamplePlace, 4> places{};
};

template <typename Grid, typename Lookup>
class GapColours {
public:
    GapColours(const Grid& grid, const Lookup& lookup, const GapLookUp& task)
        : grid_(grid), lookup_(lookup), task_(task), rays_(task.eye.camera, task.eye.pose, grid.pose()),
          agreement_{std::max(float(grid.box_radius_m()), rays_.distance_m()),
                     float(std::sin(error_budget_rad(task.eye.camera.focal_px())))} {}

    bool by_surface(int x, int y, std::uint8_t* rgba) const {
        const FloatImage& inverse_planar = task_.seen.inverse_planar();
        const float inverse = inverse_planar.pixel(x, y)[0];
        if (!(inverse >= 0))
            return false;
        const Vec3f d = rays_.direction(x, y) + rays_.eye() * inverse;
        const PixelPosition position = lookup_.project(d);
        Neighbourhood around;
        if (!lookup_.contains(position) || !find(position, around))
            return false;
        if (rays_.shows_back_to_source(inverse_planar, x, y))
            return false;
        keep_same_surface(around, agreement_.reach(std::sqrt(dot(d, d)) / inverse), x, y);
        return mix(around, rgba);
    }

    bool by_direction(int x, int y, std::uint8_t* rgba) const {
        const PixelPosition position = lookup_.project(rays_.direction(x, y));
        Neighbourhood around;
        return lookup_.contains(position) && find(position, around) && mix(around, rgba);
    }

private:
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

    void keep_same_surface(Neighbourhood& around, float reach, int x, int y) const {
        bool sloped = false;
        Vec3f gradient;
        for (int k = 0; k < 4; ++k) {
            if (around.taps.weight[k] == 0)
                continue;
            const float reach_sample = agreement_.reach(grid_.depth_m(around.places[k]));
            if (agreement_.same(reach, reach_sample))
                continue;
            if (!sloped)
                gradient = rays_.inverse_distance_gradient(task_.seen.inverse_planar(), x, y);
            sloped = true;
            const float inverse = dot(gradient, lookup_.unit_direction(around.taps.x[k], around.taps.y[k]));
            const float predicted = inverse > 1 / far_distance_m ? 1 / inverse : far_distance_m;
            if (!agreement_.between(reach, agreement_.reach(predicted), reach_sample))
                around.taps.weight[k] = 0;
        }
    }

    bool mix(const Neighbourhood& around, std::uint8_t* rgba) const {
        float sum = 0;
        Vec3f colour;
        for (int k = 0; k < 4; ++k) {
            const float weight = around.taps.weight[k];
            if (weight == 0)
                continue;
            sum += weight;
            colour = colour + grid_.colour(around.places[k]) * weight;
        }
        if (!(sum > least_weight))
            return false;
        rgba[0] = std::uint8_t(colour.x / sum + 0.5f);
        rgba[1] = std::uint8_t(colour.y / sum + 0.5f);
        rgba[2] = std::uint8_t(colour.z / sum + 0.5f);
        rgba[3] = 255;
        return true;
    }

    const Grid& grid_;
    const Lookup& lookup_;
    const GapLookUp& task_;
    EyeRays rays_;
    DepthAgreement agreement_;
};

/// Runs colour_pixel(x, y, rgba) -> coloured? for every gap that is still open, on all cores.
template <typename ColourPixel>
std::int64_t over_gaps(const GapLookUp& task, EyePicture& picture, const ColourPixel& colour_pixel) {
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

template <typename Grid, typename Run>
std::int64_t with_lookup(const Grid& grid, const Run& run) {
    if (const auto* sphere = std::get_if<EquirectCamera>(&grid.camera()))
        return run(EquirectLookup(*sphere));
    return run(PerspectiveLookup(std::get<PerspectiveCamera>(grid.camera())));
}

template <typename Grid>
std::int64_t by_surface(const Grid& grid, const GapLookUp& task, EyePicture& picture) {
    return with_lookup(grid, [&](const auto& lookup) {
        const GapColours colours(grid, lookup, task);
        return over_gaps(task, picture, [&](int x, int y, std::uint8_t* rgba) {
            if (!colours.by_surface(x, y, rgba))
                return false;
            // By direction nothing tells how far it is: depth stays NaN there.
            if (!picture.depth_m.empty())
                picture.depth_m.pixel(x, y)[0] =
                    radial_over_planar(task.eye.camera, x, y) / task.seen.inverse_planar().pixel(x, y)[0];
            return true;
        });
    });
}

}  // namespace

std::int64_t look_up_gaps(const PictureGrid& grid, const GapLookUp& task, EyePicture& picture) {
    return by_surface(grid, task, picture);
}

std::int64_t look_up_gaps(const PatchGrid& grid, const GapLookUp& task, EyePicture& picture) {
    return by_surface(grid, task, picture);
}

std::int64_t look_up_gaps_by_direction(const PictureGrid& grid, const GapLookUp& task, EyePicture& picture) {
    return with_lookup(grid, [&](const auto& lookup) {
        const GapColours colours(grid, lookup, task);
        return over_gaps(task, picture,
                         [&](int x, int y, std::uint8_t* rgba) { return colours.by_direction(x, y, rgba); });
    });
}

}  // namespace equistream
