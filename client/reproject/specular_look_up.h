#pragma once
/// What an eye sees in the mirrors and panes of one picture (specular.h), pixel by pixel.
#include "eye_rays.h"
#include "source_lookup.h"

#include "../fill/sample_grid.h"

#include <equistream/depth_agreement.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream {

/// A sample of a picture that has a mask.
struct SpecularSample {
    int x = 0, y = 0;
    bool specular = false;
};

inline SpecularSample specular_sample(const SourceView& source, int x, int y) {
    constexpr float is_specular = 0.5f;  // of a mask of 0 and 1
    return {x, y, source.specular.pixel(x, y)[0] > is_specular};
}

/// Distance of the image that a sample shows, NaN where it is not known.
inline float image_distance(const SourceView& source, const SpecularSample& s) {
    if (source.virtual_depth_m.data == nullptr)
        return std::nanf("");
    const float distance_m = source.virtual_depth_m.pixel(s.x, s.y)[0];
    return distance_m > 0 ? std::min(distance_m, far_distance_m) : std::nanf("");
}

/// Whether an image at one distance, warped with a surface at another, stays within the budget; both as seen from the
/// picture's centre. An image whose distance nobody has told lies somewhere from the surface to infinity.
inline bool warps_with_surface(const DepthAgreement& agreement, float surface_m, float image_m) {
    const auto w = [&](float distance_m) { return agreement.box_radius_m / agreement.reach(distance_m); };
    return std::abs((std::isnan(image_m) ? 0 : w(image_m)) - w(surface_m)) <= agreement.tolerance;
}

/// The picture needs depth and a mask.
template <typename Lookup>
class SpecularLookUp {
public:
    SpecularLookUp(const Lookup& lookup, const SourceView& source, const EyeView& eye, double budget_rad)
        : lookup_(lookup), source_(source), grid_(source),
          rays_(eye.camera, eye.pose, source.pose), agreement_{std::max(float(source.box_radius_m), rays_.distance_m()),
                                                               float(std::sin(budget_rad))},
          from_here_{rays_.distance_m(), agreement_.tolerance}, width_(width_of(source.camera)),
          height_(height_of(source.camera)) {}

    enum class Answer {
        untouched,  ///< no mirror
        kept,       ///< right as warped with the surface
        by_image,   ///< coloured: found by virtual depth
        gap
    };

    /// `depth_m`: of what the eye's pixel shows.
    Answer look(int x, int y, float depth_m, std::uint8_t* rgba) const {
        if (!(depth_m > 0))
            return Answer::untouched;
        const Vec3f point = rays_.eye() * (1 / std::min(depth_m, far_distance_m)) + ray(x, y);
        return look_at(sample(lookup_.project(point)), x, y, depth_m, rgba);
    }

    /// The same where it is known which sample shows the pixel's surface.
    Answer look_at(const SpecularSample& surface, int x, int y, float depth_m, std::uint8_t* rgba) const {
        if (!surface.specular)
            return Answer::untouched;
        const float image_m = image_distance(source_, surface);
        if (warps_with_surface(from_here_, source_.depth_m.pixel(surface.x, surface.y)[0], image_m))
            return Answer::kept;
        if (std::isnan(image_m))
            return Answer::gap;
        float nearest_m = std::numeric_limits<float>::infinity();
        PixelPosition found;
        for (const float start_m : {image_m, std::min(depth_m, far_distance_m), far_distance_m}) {
            PixelPosition position;
            const float distance_m = follow(ray(x, y), start_m, position);
            if (distance_m < nearest_m) {
                nearest_m = distance_m;
                found = position;
            }
        }
        return std::isfinite(nearest_m) && mix(found, rgba) ? Answer::by_image : Answer::gap;
    }

private:
    Vec3f ray(int x, int y) const { return rays_.direction(x, y) * (1 / rays_.length(x, y)); }
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
        constexpr int most_steps = 24;
        for (int step = 0; step < most_steps; ++step) {
            const Vec3f point = rays_.eye() + ray * distance_m;
            position = lookup_.project(point);
            const SpecularSample seen = sample(position);
            const float image_m = seen.specular ? image_distance(source_, seen) : std::nanf("");
            if (std::isnan(image_m))
                return std::numeric_limits<float>::infinity();
            const Vec3f image = point * (image_m / std::sqrt(dot(point, point)));
            const Vec3f from_eye = image + rays_.eye() * -1;
            const float next_m = dot(from_eye, ray);
            if (!(next_m > 0))
                return std::numeric_limits<float>::infinity();
            const Vec3f beside = from_eye + ray * -next_m;
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
    DepthAgreement from_here_;  ///< with this eye's own distance from the picture's centre for B
    int width_, height_;
};

/// Runs run(lookup) with the look-up of a camera.
template <typename Run>
auto with_lookup(const Camera& camera, const Run& run) {
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera))
        return run(EquirectLookup(*sphere));
    return run(PerspectiveLookup(std::get<PerspectiveCamera>(camera)));
}

}  // namespace equistream
