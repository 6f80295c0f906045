#include "eye_rays.h"

#include <limits>

namespace equistream {

namespace {

Vec3f to_float(const glm::dvec3& v) {
    return {float(v.x), float(v.y), float(v.z)};
}

/// The smaller of the two one-sided differences; NaN neighbours do not count, and without any the slope is 0.
float one_sided_slope(float before, float here, float after) {
    const float a = here - before;
    const float b = after - here;
    const float size_a = std::isnan(a) ? std::numeric_limits<float>::infinity() : std::abs(a);
    const float size_b = std::isnan(b) ? std::numeric_limits<float>::infinity() : std::abs(b);
    if (std::isinf(std::min(size_a, size_b)))
        return 0;
    return size_a <= size_b ? a : b;
}

}  // namespace

EyeRays::EyeRays(const PerspectiveCamera& camera, const Pose& eye, const Pose& source)
    : focal_(float(camera.focal_px())), inverse_focal_(float(1 / camera.focal_px())),
      centre_x_(0.5f * float(camera.width) - 0.5f), centre_y_(0.5f * float(camera.height) - 0.5f) {
    const glm::dquat source_from_world = glm::conjugate(source.orientation);
    const glm::dmat3 rotation = glm::mat3_cast(source_from_world * eye.orientation);
    const double step = 1 / camera.focal_px();
    const glm::dvec3 corner((0.5 - 0.5 * camera.width) * step, (0.5 * camera.height - 0.5) * step, -1);
    corner_ = to_float(rotation * corner);
    right_ = to_float(rotation * glm::dvec3(step, 0, 0));
    down_ = to_float(rotation * glm::dvec3(0, -step, 0));
    eye_ = to_float(source_from_world * (eye.position_m - source.position_m));
    source_from_eye_ = glm::mat3(rotation);
}

float EyeRays::inverse_planar_depth(ImageView<const float> depth_m, int x, int y) const {
    if (x < 0 || y < 0 || x >= depth_m.width || y >= depth_m.height)
        return std::numeric_limits<float>::quiet_NaN();
    return length(x, y) / depth_m.pixel(x, y)[0];
}

Vec3f EyeRays::inverse_distance_gradient(ImageView<const float> depth_m, int x, int y) const {
    // In the eye's own frame a plane is n . X = 1 and inverse planar depth is n . (a, b, -1): linear in the pixel.
    const float z = inverse_planar_depth(depth_m, x, y);
    const float slope_x =
        one_sided_slope(inverse_planar_depth(depth_m, x - 1, y), z, inverse_planar_depth(depth_m, x + 1, y));
    const float slope_y =
        one_sided_slope(inverse_planar_depth(depth_m, x, y - 1), z, inverse_planar_depth(depth_m, x, y + 1));
    const glm::vec3 n(slope_x * focal_, -slope_y * focal_,
                      slope_x * (float(x) - centre_x_) + slope_y * (float(y) - centre_y_) - z);
    const glm::vec3 m = source_from_eye_ * n;
    const float at_source = 1 + m.x * eye_.x + m.y * eye_.y + m.z * eye_.z;
    return Vec3f{m.x, m.y, m.z} * (1 / at_source);
}

}  // namespace equistream
