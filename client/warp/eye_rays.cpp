#include "eye_rays.h"

#include <limits>

namespace equistream {

namespace {

/// Differences to the neighbours on either side, per pixel; NaN where there is none.
struct Slopes {
    float before = 0, after = 0;

    /// The smaller one; 0 if there is neither.
    float believed() const {
        if (std::isnan(before))
            return std::isnan(after) ? 0 : after;
        return std::isnan(after) || std::abs(before) <= std::abs(after) ? before : after;
    }
};

float at_or_nan(const FloatImage& image, int x, int y) {
    const bool inside = x >= 0 && y >= 0 && x < image.width() && y < image.height();
    return inside ? image.pixel(x, y)[0] : std::numeric_limits<float>::quiet_NaN();
}

Slopes slopes(const FloatImage& image, int x, int y, int dx, int dy) {
    const float here = image.pixel(x, y)[0];
    return {here - at_or_nan(image, x - dx, y - dy), at_or_nan(image, x + dx, y + dy) - here};
}

/// The larger product of a factor with either slope; NaN neighbours do not count.
float max_product(Slopes slopes, float factor) {
    return std::fmax(slopes.before * factor, slopes.after * factor);
}

}  // namespace

EyeRays::EyeRays(const PerspectiveCamera& camera, const Pose& eye, const Pose& source)
    : focal_(float(camera.focal_px())), inverse_focal_(float(1 / camera.focal_px())),
      centre_x_(0.5f * float(camera.width) - 0.5f), centre_y_(0.5f * float(camera.height) - 0.5f) {
    const glm::dquat source_from_world = glm::conjugate(source.orientation);
    const glm::dmat3 rotation = glm::mat3_cast(source_from_world * eye.orientation);
    const double step = 1 / camera.focal_px();
    const glm::dvec3 corner((0.5 - 0.5 * camera.width) * step, (0.5 * camera.height - 0.5) * step, -1);
    corner_ = glm::vec3(rotation * corner);
    right_ = glm::vec3(rotation * glm::dvec3(step, 0, 0));
    down_ = glm::vec3(rotation * glm::dvec3(0, -step, 0));
    eye_ = glm::vec3(source_from_world * (eye.position_m - source.position_m));
    eye_own_axes_ = glm::vec3(glm::conjugate(eye.orientation) * (eye.position_m - source.position_m));
    source_from_eye_ = glm::mat3(rotation);
}

bool EyeRays::shows_back_to_source(const FloatImage& inverse_planar, int x, int y) const {
    // With n as below, n . X - 1 is negative at the eye and -(1 + n . c) at the source, c being the eye seen from it;
    // linear in the slopes, so the extremes are at the neighbours.
    const glm::vec3 c = eye_own_axes_;
    const float by_slope_x = c.x * focal_ + c.z * (float(x) - centre_x_);
    const float by_slope_y = -c.y * focal_ + c.z * (float(y) - centre_y_);
    const float largest = 1 - c.z * inverse_planar.pixel(x, y)[0] +
                          max_product(slopes(inverse_planar, x, y, 1, 0), by_slope_x) +
                          max_product(slopes(inverse_planar, x, y, 0, 1), by_slope_y);
    return largest < 0;
}

glm::vec3 EyeRays::inverse_distance_gradient(const FloatImage& inverse_planar, int x, int y) const {
    // In the eye's own frame a plane is n . X = 1 and inverse planar depth is n . (a, b, -1): linear in the pixel.
    const float z = inverse_planar.pixel(x, y)[0];
    const float slope_x = slopes(inverse_planar, x, y, 1, 0).believed();
    const float slope_y = slopes(inverse_planar, x, y, 0, 1).believed();
    const glm::vec3 n(slope_x * focal_, -slope_y * focal_,
                      slope_x * (float(x) - centre_x_) + slope_y * (float(y) - centre_y_) - z);
    const glm::vec3 m = source_from_eye_ * n;
    const float at_source = 1 + m.x * eye_.x + m.y * eye_.y + m.z * eye_.z;
    return m * (1 / at_source);
}

}  // namespace equistream
