#include "gap_look_up.h"

#include "../reproject/specular_look_up.h"

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

/// Where a grid has what a gap pixel sees.
template <typename Grid, typename Lookup>
class PointSamples {
public:
    PointSamples(const Grid& grid, const Lookup& lookup, const GapLookUp& task)
        : grid_(grid), lookup_(lookup), task_(task), rays_(task.eye.camera, task.eye.pose, grid.pose()),
          agreement_{std::max(float(grid.box_radius_m()), rays_.distance_m()),
                     float(std::sin(error_budget_rad(task.eye.camera.focal_px())))} {}

    /// Samples of the surface that the pixel sees: false if there are too few.
    bool of_surface(int x, int y, Neighbourhood& around) const {
        const FloatImage& inverse_planar = task_.seen.inverse_planar();
        const float inverse = inverse_planar.pixel(x, y)[0];
        if (!(inverse >= 0))
            return false;
        const Vec3f d = rays_.direction(x, y) + rays_.eye() * inverse;
        const PixelPosition position = lookup_.project(d);
        if (!lookup_.contains(position) || !find(position, around))
            return false;
        if (rays_.shows_back_to_source(inverse_planar, x, y))
            return false;
        keep_same_surface(around, agreement_.reach(std::sqrt(dot(d, d)) / inverse), x, y);
        return enough(around);
    }

    bool in_direction(int x, int y, Neighbourhood& around) const {
        const PixelPosition position = lookup_.project(rays_.direction(x, y));
        return lookup_.contains(position) && find(position, around) && enough(around);
    }

    void mix(const Neighbourhood& around, std::uint8_t* rgba) const {
        float sum = 0;
        Vec3f colour;
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
        const float inverse = task_.seen.inverse_planar().pixel(x, y)[0];
        const Vec3f d = rays_.direction(x, y) + rays_.eye() * inverse;
        return inverse / std::sqrt(dot(d, d));
    }
    float eye_distance_m() const { return rays_.distance_m(); }

private:
    static bool enough(const Neighbourhood& around) {
        const auto& w = around.taps.weight;
        return w[0] + w[1] + w[2] + w[3] > least_weight;
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

    const Grid& grid_;
    const Lookup& lookup_;
    const GapLookUp& task_;
    EyeRays rays_;
    DepthAgreement agreement_;
};

/// What a gap pixel that sees a mirror or glass takes from a picture's samples of that surface.
enum class InMirror { as_surface, coloured, passed_over };

/// The heaviest of the four.
SpecularSample main_sample(const SourceView& view, const Neighbourhood& around) {
    const auto& weight = around.taps.weight;
    const auto k = std::size_t(std::max_element(weight.begin(), weight.end()) - weight.begin());
    return specular_sample(view, around.taps.x[k], around.taps.y[k]);
}

struct NoMirrors {
    template <typename Samples>
    InMirror operator()(const Samples&, const Neighbourhood&, int, int, std::uint8_t*) const {
        return InMirror::as_surface;
    }
};

/// By the picture's own mask and virtual depths.
template <typename Lookup>
class OwnMirrors {
public:
    OwnMirrors(const Lookup& lookup, const SourceView& view, const GapLookUp& task)
        : view_(view), task_(task), look_up_(lookup, view, task.eye, error_budget_rad(task.eye.camera.focal_px())) {}

    template <typename Samples>
    InMirror operator()(const Samples&, const Neighbourhood& around, int x, int y, std::uint8_t* rgba) const {
        using Answer = typename SpecularLookUp<Lookup>::Answer;
        const float depth_m = radial_over_planar(task_.eye.camera, x, y) / task_.seen.inverse_planar().pixel(x, y)[0];
        const Answer answer = look_up_.look_at(main_sample(view_, around), x, y, depth_m, rgba);
        if (answer == Answer::by_image)
            rgba[3] = 255;
        return answer == Answer::by_image ? InMirror::coloured
               : answer == Answer::gap    ? InMirror::passed_over
                                          : InMirror::as_surface;
    }

private:
    const SourceView& view_;
    const GapLookUp& task_;
    SpecularLookUp<Lookup> look_up_;
};

/// Where main sees the same surface, its mask says what that is; and as far as its image lies behind it there, it does
/// as seen from elsewhere (for plane mirrors along the same ray; else nearly, the places being near each other).
template <typename MainLookup>
class MainsMirrors {
public:
    MainsMirrors(const MainLookup& lookup, const GapLookUp& task)
        : main_(*task.main), grid_(main_), samples_(grid_, lookup, task),
          tolerance_(float(std::sin(error_budget_rad(task.eye.camera.focal_px())))) {}

    template <typename Samples>
    InMirror operator()(const Samples& taken, const Neighbourhood&, int x, int y, std::uint8_t*) const {
        Neighbourhood around;
        if (!samples_.of_surface(x, y, around))
            return InMirror::as_surface;
        const SpecularSample sample = main_sample(main_, around);
        if (!sample.specular)
            return InMirror::as_surface;
        const float surface_m = std::min(1 / taken.inverse_distance(x, y), far_distance_m);
        const float behind_m = image_distance(main_, sample) - main_.depth_m.pixel(sample.x, sample.y)[0];
        const DepthAgreement agreement{taken.eye_distance_m(), tolerance_};
        return warps_with_surface(agreement, surface_m, surface_m + behind_m) ? InMirror::as_surface
                                                                              : InMirror::passed_over;
    }

private:
    const SourceView& main_;
    PictureGrid grid_;
    PointSamples<PictureGrid, MainLookup> samples_;
    float tolerance_;
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

template <typename Grid, typename Lookup, typename Mirrors>
std::int64_t colour_by_surface(const PointSamples<Grid, Lookup>& samples, const Mirrors& mirrors, const GapLookUp& task,
                               EyePicture& picture) {
    return over_gaps(task, picture, [&](int x, int y, std::uint8_t* rgba) {
        Neighbourhood around;
        if (!samples.of_surface(x, y, around))
            return false;
        const InMirror answer = mirrors(samples, around, x, y, rgba);
        if (answer == InMirror::passed_over)
            return false;
        if (answer == InMirror::as_surface)
            samples.mix(around, rgba);
        // By direction nothing tells how far it is: depth stays NaN there.
        if (!picture.depth_m.empty())
            picture.depth_m.pixel(x, y)[0] =
                radial_over_planar(task.eye.camera, x, y) / task.seen.inverse_planar().pixel(x, y)[0];
        return true;
    });
}

bool tells_of_mirrors(const SourceView& view) {
    return view.specular.data != nullptr && view.depth_m.data != nullptr;
}

template <typename Grid, typename Lookup>
std::int64_t by_surface(const PointSamples<Grid, Lookup>& samples, const GapLookUp& task, EyePicture& picture) {
    if (task.main == nullptr || !tells_of_mirrors(*task.main))
        return colour_by_surface(samples, NoMirrors{}, task, picture);
    return with_lookup(task.main->camera, [&](const auto& lookup) {
        return colour_by_surface(samples, MainsMirrors(lookup, task), task, picture);
    });
}

}  // namespace

std::int64_t look_up_gaps(const PictureGrid& grid, const GapLookUp& task, EyePicture& picture) {
    return with_lookup(grid.camera(), [&](const auto& lookup) {
        const PointSamples samples(grid, lookup, task);
        if (tells_of_mirrors(grid.view()))
            return colour_by_surface(samples, OwnMirrors(lookup, grid.view(), task), task, picture);
        return by_surface(samples, task, picture);
    });
}

std::int64_t look_up_gaps(const PatchGrid& grid, const GapLookUp& task, EyePicture& picture) {
    return with_lookup(grid.camera(),
                       [&](const auto& lookup) { return by_surface(PointSamples(grid, lookup, task), task, picture); });
}

std::int64_t look_up_gaps_by_direction(const PictureGrid& grid, const GapLookUp& task, EyePicture& picture) {
    return with_lookup(grid.camera(), [&](const auto& lookup) {
        const PointSamples samples(grid, lookup, task);
        return over_gaps(task, picture, [&](int x, int y, std::uint8_t* rgba) {
            Neighbourhood around;
            if (!samples.in_direction(x, y, around))
                return false;
            samples.mix(around, rgba);
            return true;
        });
    });
}

}  // namespace equistream
