#pragma once
/// Where a ray of the eye meets what mirrors and glass show: a search among the source's samples, each of which has its
/// image in its own direction as far away as its virtual depth says.
#include "source_lookup.h"
#include "specular_sample.h"

#include "../fill/sample_grid.h"

#include <equistream/depth_agreement.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace equistream {

/// Points and rays are in the source's frame. References must outlive it; only reads, from any number of threads.
template <typename Lookup>
class ImageLookUp {
public:
    ImageLookUp(const Lookup& lookup, const SourceView& source, Vec3f eye, const DepthAgreement& agreement)
        : lookup_(lookup), source_(source), grid_(source), eye_(eye), agreement_(agreement),
          width_(width_of(source.camera)), height_(height_of(source.camera)) {
        const auto* sphere = std::get_if<EquirectCamera>(&source.camera);
        closes_ = sphere != nullptr && sphere->range.closes();
    }

    /// The one nearest to a position; no specular one outside the picture.
    SpecularSample sample(PixelPosition p) const {
        if (!lookup_.contains(p))
            return {};
        return specular_sample(source_, std::clamp(int(p.u), 0, width_ - 1), std::clamp(int(p.v), 0, height_ - 1));
    }

    /// The first image on the eye's ray (unit) that begins at a surface so far away: along it a pixel of the source at
    /// a time.
    std::optional<PixelPosition> first_beyond(Vec3f ray, float surface_m) const {
        const PixelPosition from = lookup_.project(eye_ * (1 / surface_m) + ray), to = lookup_.project(ray);
        const int steps = std::clamp(int(std::ceil(std::hypot(to.u - from.u, to.v - from.v))), 1, most_steps);
        for (int step = 0; step <= steps; ++step) {
            const float inverse_m = (1 - float(step) / float(steps)) / surface_m;
            const Vec3f towards = eye_ * inverse_m + ray;
            const float inverse_image_m = inverse_image(sample(lookup_.project(towards)));
            const float inverse_point_m = inverse_m / std::sqrt(dot(towards, towards));
            // A step more: the image may lie between this sample and the next.
            if (!(inverse_point_m <= inverse_image_m + 1 / (surface_m * float(steps))))
                continue;
            if (const auto found = follow(ray, 1 / inverse_image_m))
                return found;
        }
        return std::nullopt;
    }

    /// Sine of how far beside an eye's ray (unit) an image lies that the source has in a direction.
    float displacement(Vec3f ray, Vec3f towards, float image_m) const {
        const Vec3f from_eye = towards * (image_m / std::sqrt(dot(towards, towards))) + eye_ * -1;
        const Vec3f beside = from_eye + ray * -dot(from_eye, ray);
        return std::sqrt(dot(beside, beside) / dot(from_eye, from_eye));
    }

    /// What is seen at a position found: of the four samples around, those that show the nearest one's image.
    Vec3f colour(PixelPosition position) const {
        const BilinearCell cell(position);
        const Taps taps = lookup_.taps(position);
        const int near_x = position.u - 0.5f - float(cell.x) >= 0.5f;
        const int near_y = position.v - 0.5f - float(cell.y) >= 0.5f;
        const bool beside = joined(cell.x, cell.y + near_y, 1, 0), above = joined(cell.x + near_x, cell.y, 0, 1);
        const bool across = (beside && joined(cell.x + 1 - near_x, cell.y, 0, 1)) ||
                            (above && joined(cell.x, cell.y + 1 - near_y, 1, 0));
        float sum = 0;
        Vec3f colour;
        for (int k = 0; k < 4; ++k) {
            const bool far_x = (k & 1) != near_x, far_y = (k >> 1) != near_y;
            if ((far_x && far_y && !across) || (far_x && !far_y && !beside) || (far_y && !far_x && !above))
                continue;
            sum += taps.weight[k];
            colour = colour + grid_.colour({taps.x[k], taps.y[k]}) * taps.weight[k];
        }
        return colour * (1 / sum);
    }

private:
    static constexpr int most_steps = 64;
    static constexpr int most_turns = 24;

    /// 1 / distance; NaN where a sample shows no image, or nobody has told where it lies.
    float inverse_image(const SpecularSample& s) const {
        return s.specular ? 1 / image_distance(source_, s) : std::nanf("");
    }
    float inverse_image(int x, int y) const {
        if (y < 0 || y >= height_)
            return std::nanf("");
        return inverse_image(
            specular_sample(source_, closes_ ? (x + width_) % width_ : std::clamp(x, 0, width_ - 1), y));
    }

    /// From a distance along the eye's ray to the image that the source has in that direction, to the ray's point
    /// nearest to it, and so on, until the image lies on the ray: where the source has it, if anywhere.
    std::optional<PixelPosition> follow(Vec3f ray, float distance_m) const {
        for (int turn = 0; turn < most_turns; ++turn) {
            const Vec3f point = eye_ + ray * distance_m;
            const float inverse_image_m = inverse_image(sample(lookup_.project(point)));
            if (std::isnan(inverse_image_m))
                return std::nullopt;
            const Vec3f from_eye = point * (1 / (inverse_image_m * std::sqrt(dot(point, point)))) + eye_ * -1;
            const float next_m = dot(from_eye, ray);
            if (!(next_m > 0))
                return std::nullopt;
            const Vec3f beside = from_eye + ray * -next_m;
            if (std::sqrt(dot(beside, beside)) <= agreement_.tolerance * next_m) {
                const PixelPosition found = lookup_.project(eye_ + ray * next_m);
                return std::isnan(inverse_image(sample(found))) ? std::nullopt : std::optional(found);
            }
            distance_m = next_m;
        }
        return std::nullopt;
    }

    /// Whether the neighbours at (x, y) and one step further show one image.
    bool joined(int x, int y, int dx, int dy) const {
        return agreement_.connected(inverse_image(x - dx, y - dy), inverse_image(x, y), inverse_image(x + dx, y + dy),
                                    inverse_image(x + 2 * dx, y + 2 * dy));
    }

    const Lookup& lookup_;
    const SourceView& source_;
    PictureGrid grid_;
    Vec3f eye_;
    DepthAgreement agreement_;
    int width_, height_;
    bool closes_ = false;
};

}  // namespace equistream
