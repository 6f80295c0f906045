#include "plain_engines.h"

#include <client/reflections/mirror_kernels.h>

#include <equistream/virtual_image.h>

#include <cmath>
#include <limits>
#include <optional>

namespace equistream::plain {

namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double infinity = std::numeric_limits<double>::infinity();

struct SourceSample {
    int x = 0, y = 0;
};

class PlainImages {
public:
    explicit PlainImages(const MirrorJob& job)
        : source_(job.source), looks_for_images_(job.looks_for_images),
          eye_(glm::inverse(job.source.pose.orientation) * (job.eye.pose.position_m - job.source.pose.position_m)),
          radius_m_(job.agreement.box_radius_m), tolerance_(job.agreement.tolerance) {}

    /// How a ray of the eye is answered that meets `surface_m` away what a mirror's sample shows; `at` if by an image.
    MirrorAnswer answer(dvec3 ray, double surface_m, SourceSample sample, dvec2& at) const {
        const std::optional<double> image_m = image_distance(sample);
        const double w_surface = w(source_.depth_m.pixel(sample.x, sample.y)[0]);
        const bool kept = std::abs((image_m ? w(*image_m) : 0) - w_surface) <= tolerance_;
        if (!looks_for_images_)
            return image_m && kept ? MirrorAnswer::kept : MirrorAnswer::gap;
        if (kept)
            return MirrorAnswer::kept;
        if (!image_m)
            return MirrorAnswer::gap;
        if (const auto found = first_image(ray, surface_m)) {
            at = *found;
            return MirrorAnswer::by_image;
        }
        const dvec3 image = glm::normalize(eye_ + surface_m * ray) * *image_m - eye_;
        const double sine = glm::length(glm::cross(glm::normalize(image), ray));
        return sine <= max_image_displacement ? MirrorAnswer::displaced : MirrorAnswer::gap;
    }

    /// The one nearest to what lies in a direction, if a mirror's.
    std::optional<SourceSample> mirror_in(dvec3 direction) const {
        const dvec2 p = pixel_of(source_.camera, direction);
        const int width = width_of(source_.camera), height = height_of(source_.camera);
        constexpr double edge = 0.02;
        if (!(p.x >= -edge && p.x <= width + edge && p.y >= -edge && p.y <= height + edge))
            return std::nullopt;
        const SourceSample s{std::clamp(int(std::floor(p.x)), 0, width - 1),
                             std::clamp(int(std::floor(p.y)), 0, height - 1)};
        return source_.specular.pixel(s.x, s.y)[0] > min_specular ? std::optional(s) : std::nullopt;
    }
    dvec3 from_source(dvec3 ray, double distance_m) const { return eye_ / distance_m + ray; }

private:
    std::optional<double> image_distance(SourceSample s) const {
        if (source_.virtual_depth_m.data == nullptr)
            return std::nullopt;
        const double image_m = source_.virtual_depth_m.pixel(s.x, s.y)[0];
        return image_m > 0 ? std::optional(std::min(image_m, double(far_distance_m))) : std::nullopt;
    }
    std::optional<double> image_in(dvec3 direction) const {
        const auto sample = mirror_in(direction);
        return sample ? image_distance(*sample) : std::nullopt;
    }

    double w(double distance_m) const {
        const double r = std::min(distance_m, double(far_distance_m));
        return radius_m_ / std::max(r - radius_m_, 1e-3 * r);
    }

    /// The first image on the ray beyond the surface, a sample of the source after the other.
    std::optional<dvec2> first_image(dvec3 ray, double surface_m) const {
        const double apart =
            glm::length(pixel_of(source_.camera, ray) - pixel_of(source_.camera, from_source(ray, surface_m)));
        // As many as there are where a flat picture does not hold the ray's end.
        const int steps = apart <= max_image_steps ? std::max(1, int(std::ceil(apart))) : max_image_steps;
        bool before = true;
        for (int step = 0; step <= steps; ++step) {
            const double distance_m = step < steps ? surface_m * steps / (steps - step) : infinity;
            const dvec3 towards = from_source(ray, distance_m);
            const std::optional<double> image_m = image_in(towards);
            // A step more: the image may lie between this sample and the next.
            const double inverse_m = 1 / distance_m / glm::length(towards);
            const bool behind = image_m && inverse_m <= 1 / *image_m + 1 / (surface_m * steps);
            if (behind && (before || step == steps))
                if (const auto found = follow(ray, *image_m))
                    return found;
            before = !behind;
        }
        return std::nullopt;
    }

    /// From a distance along the ray to the image in that direction, to the ray's point nearest to it, and so on.
    std::optional<dvec2> follow(dvec3 ray, double distance_m) const {
        for (int turn = 0; turn < max_image_turns; ++turn) {
            const dvec3 point = eye_ + distance_m * ray;
            const std::optional<double> image_m = image_in(point);
            if (!image_m)
                return std::nullopt;
            const dvec3 from_eye = glm::normalize(point) * *image_m - eye_;
            distance_m = glm::dot(from_eye, ray);
            if (!(distance_m > 0))
                return std::nullopt;
            if (glm::length(from_eye - distance_m * ray) > tolerance_ * distance_m)
                continue;
            const dvec3 found = eye_ + distance_m * ray;
            return image_in(found) ? std::optional(pixel_of(source_.camera, found)) : std::nullopt;
        }
        return std::nullopt;
    }

    const SourceView& source_;
    bool looks_for_images_;
    dvec3 eye_;
    double radius_m_, tolerance_;
};

void find_images_plainly(const MirrorJob& job, int y, MirrorRow& row) {
    const PlainImages images(job);
    const glm::dquat source_from_eye = glm::inverse(job.source.pose.orientation) * job.eye.pose.orientation;
    row.count = 0;
    for (int x = 0; x < job.eye.camera.width; ++x) {
        const double depth_m = job.eye.depth_m.pixel(x, y)[0];
        if (*job.origin.pixel(x, y) != std::uint8_t(PixelOrigin::source) || !(depth_m > 0))
            continue;
        const double surface_m = std::min(depth_m, double(far_distance_m));
        const dvec3 ray = glm::normalize(source_from_eye * job.eye.camera.direction(x + 0.5, y + 0.5));
        const auto sample = images.mirror_in(images.from_source(ray, surface_m));
        if (!sample)
            continue;
        const auto i = std::size_t(row.count++);
        dvec2 at{0};
        row.x[i] = x;
        row.answer[i] = std::uint8_t(images.answer(ray, surface_m, *sample, at));
        row.u[i] = float(at.x);
        row.v[i] = float(at.y);
    }
}

}  // namespace

SpecularCounts rework_specular(const SourceView& source, const EyeView& eye, EyePicture& picture,
                               const SpecularOptions& options) {
    return rework_specular_by(find_images_plainly, source, eye, picture, options);
}

}  // namespace equistream::plain
