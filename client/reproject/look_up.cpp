#include "look_up.h"

#include "eye_rays.h"
#include "source_lookup.h"

#include <equistream/depth_agreement.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cassert>
#include <vector>

namespace equistream {

namespace {

/// One row of the eye in the source: where each pixel falls and how far its point is from the source's centre.
struct MappedRow {
    std::vector<PixelPosition> position;
    std::vector<float> distance_m;
};

struct Span {
    int begin = 0, end = 0;
};

/// The pixels of a row that are still to be coloured, from the first to the last.
Span open_span(const LookUpOptions& options, const EyePicture& picture, int y) {
    Span span{0, picture.origin.width()};
    if (!options.only_gaps)
        return span;
    const std::uint8_t* origin = picture.origin.pixel(0, y);
    while (span.begin < span.end && origin[span.begin] != std::uint8_t(PixelOrigin::gap))
        ++span.begin;
    while (span.end > span.begin && origin[span.end - 1] != std::uint8_t(PixelOrigin::gap))
        --span.end;
    return span;
}

/// Weighted mean of the four samples; the weights need not add up to one.
inline void mix(ImageView<const std::uint8_t> rgb, const Taps& taps, std::uint8_t* rgba) {
    float sum = 0, r = 0, g = 0, b = 0;
    for (int k = 0; k < 4; ++k) {
        const std::uint8_t* sample = rgb.pixel(taps.x[k], taps.y[k]);
        const float w = taps.weight[k];
        sum += w;
        r += w * float(sample[0]);
        g += w * float(sample[1]);
        b += w * float(sample[2]);
    }
    const float scale = 1 / sum;
    rgba[0] = std::uint8_t(r * scale + 0.5f);
    rgba[1] = std::uint8_t(g * scale + 0.5f);
    rgba[2] = std::uint8_t(b * scale + 0.5f);
    rgba[3] = 255;
}

/// Below this share of the four samples' weight what is left lies too far to one side of the point to stand for it.
constexpr float least_weight = 0.1f;

/// Takes the weight from samples that show another surface than the eye's; false if too little is left.
template <typename Lookup>
class SurfaceTest {
public:
    SurfaceTest(const Lookup& lookup, const DepthAgreement& agreement, const SourceView& source, const EyeView& eye,
                const EyeRays& rays)
        : lookup_(lookup), agreement_(agreement), source_depth_(source.depth_m), rays_(rays),
          inverse_planar_(rays.inverse_planar_depth(eye.depth_m)) {}

    /// 1 / planar depth of the eye's pixels; NaN where its depth is no distance.
    const FloatImage& inverse_planar() const { return inverse_planar_; }

    bool keep_same_surface(Taps& taps, float distance_m, int x, int y) const {
        if (rays_.shows_back_to_source(inverse_planar_, x, y))
            return false;
        const float reach = agreement_.reach(distance_m);
        std::array<float, 4> reach_sample{};
        unsigned disagreeing = 0;
        for (int k = 0; k < 4; ++k) {
            reach_sample[k] = agreement_.reach(source_depth_.pixel(taps.x[k], taps.y[k])[0]);
            disagreeing |= agreement_.same(reach, reach_sample[k]) ? 0u : 1u << k;
        }
        if (disagreeing != 0)
            allow_slope(taps, reach, reach_sample, disagreeing, {x, y});
        return taps.weight[0] + taps.weight[1] + taps.weight[2] + taps.weight[3] > least_weight;
    }

private:
    struct EyePixel {
        int x, y;
    };

    void allow_slope(Taps& taps, float reach, const std::array<float, 4>& reach_sample, unsigned disagreeing,
                     EyePixel pixel) const {
        const Vec3f gradient = rays_.inverse_distance_gradient(inverse_planar_, pixel.x, pixel.y);
        for (int k = 0; k < 4; ++k) {
            if ((disagreeing >> k & 1u) == 0)
                continue;
            const float inverse = dot(gradient, lookup_.unit_direction(taps.x[k], taps.y[k]));
            const float predicted = inverse > 1 / far_distance_m ? 1 / inverse : far_distance_m;
            if (!agreement_.between(reach, agreement_.reach(predicted), reach_sample[k]))
                taps.weight[k] = 0;
        }
    }

    const Lookup& lookup_;
    const DepthAgreement& agreement_;
    ImageView<const float> source_depth_;
    const EyeRays& rays_;
    FloatImage inverse_planar_;
};

/// Runs `colour_pixel(x, y, rgba)` -> coloured? over the open pixels of all rows, on all cores.
template <typename MapRow, typename ColourPixel>
std::int64_t over_open_pixels(const LookUpOptions& options, EyePicture& picture, const MapRow& map_row,
                              const ColourPixel& colour_pixel) {
    std::atomic<std::int64_t> coloured{0};
    tbb::parallel_for(tbb::blocked_range<int>(0, picture.origin.height(), 8), [&](const tbb::blocked_range<int>& rows) {
        MappedRow mapped{std::vector<PixelPosition>(std::size_t(picture.origin.width())),
                         std::vector<float>(std::size_t(picture.origin.width()))};
        std::int64_t count = 0;
        for (int y = rows.begin(); y < rows.end(); ++y) {
            const Span span = open_span(options, picture, y);
            map_row(y, span, mapped);
            std::uint8_t* origin = picture.origin.pixel(0, y);
            std::uint8_t* rgba = picture.rgba.pixel(0, y);
            for (int x = span.begin; x < span.end; ++x) {
                if (options.only_gaps && origin[x] != std::uint8_t(PixelOrigin::gap))
                    continue;
                const bool found = colour_pixel(x, y, mapped, rgba + 4 * x);
                origin[x] = std::uint8_t(found ? options.mark : PixelOrigin::gap);
                count += found ? 1 : 0;
            }
        }
        coloured += count;
    });
    return coloured;
}

template <typename Lookup>
std::int64_t by_direction(const Lookup& lookup, const SourceView& source, const EyeView& eye,
                          const LookUpOptions& options, EyePicture& picture) {
    const EyeRays rays(eye.camera, eye.pose, source.pose);
    const auto map_row = [&](int y, Span span, MappedRow& mapped) {
        for (int x = span.begin; x < span.end; ++x)
            mapped.position[x] = lookup.project(rays.direction(x, y));
    };
    const auto colour_pixel = [&](int x, int, const MappedRow& mapped, std::uint8_t* rgba) {
        if (!lookup.contains(mapped.position[x]))
            return false;
        mix(source.rgb, lookup.taps(mapped.position[x]), rgba);
        return true;
    };
    return over_open_pixels(options, picture, map_row, colour_pixel);
}

template <typename Lookup>
std::int64_t by_surface(const Lookup& lookup, const SourceView& source, const EyeView& eye,
                        const LookUpOptions& options, EyePicture& picture) {
    const EyeRays rays(eye.camera, eye.pose, source.pose);
    const DepthAgreement agreement{std::max(float(source.box_radius_m), rays.distance_m()),
                                   float(std::sin(options.tolerance_rad))};
    const SurfaceTest<Lookup> test(lookup, agreement, source, eye, rays);
    const Vec3f centre = rays.eye();
    const auto map_row = [&](int y, Span span, MappedRow& mapped) {
        const float* inverse_planar = test.inverse_planar().pixel(0, y);
        for (int x = span.begin; x < span.end; ++x) {
            // The point over its planar depth: at infinity only the direction is left, with no case of its own.
            const float inverse = inverse_planar[x];
            const Vec3f d = rays.direction(x, y) + centre * inverse;
            mapped.position[x] = lookup.project(d);
            mapped.distance_m[x] = std::sqrt(dot(d, d)) / inverse;
        }
    };
    const auto colour_pixel = [&](int x, int y, const MappedRow& mapped, std::uint8_t* rgba) {
        if (!lookup.contains(mapped.position[x]))
            return false;
        Taps taps = lookup.taps(mapped.position[x]);
        if (!test.keep_same_surface(taps, mapped.distance_m[x], x, y))
            return false;
        mix(source.rgb, taps, rgba);
        return true;
    };
    return over_open_pixels(options, picture, map_row, colour_pixel);
}

template <typename Run>
std::int64_t with_lookup(const Camera& camera, const Run& run) {
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera))
        return run(EquirectLookup(*sphere));
    return run(PerspectiveLookup(std::get<PerspectiveCamera>(camera)));
}

[[maybe_unused]] bool fits(const SourceView& source) {
    return source.rgb.width == width_of(source.camera) && source.rgb.height == height_of(source.camera) &&
           source.rgb.channels >= 3;
}

}  // namespace

std::int64_t look_up_by_direction(const SourceView& source, const EyeView& eye, const LookUpOptions& options,
                                  EyePicture& picture) {
    assert(fits(source));
    return with_lookup(source.camera,
                       [&](const auto& lookup) { return by_direction(lookup, source, eye, options, picture); });
}

std::int64_t look_up_by_surface(const SourceView& source, const EyeView& eye, const LookUpOptions& options,
                                EyePicture& picture) {
    assert(fits(source) && source.depth_m.width == source.rgb.width && source.depth_m.height == source.rgb.height);
    assert(eye.depth_m.width == eye.camera.width && eye.depth_m.height == eye.camera.height);
    return with_lookup(source.camera,
                       [&](const auto& lookup) { return by_surface(lookup, source, eye, options, picture); });
}

}  // namespace equistream
