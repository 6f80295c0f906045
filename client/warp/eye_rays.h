#pragma once
/// The rays of an eye's pixels.
#include "view.h"

#include <glm/glm.hpp>

namespace equistream {

// The rays of an eye's pixels in a source's camera frame, in single precision: linear in the pixel's coordinates.

class EyeRays {
public:
    EyeRays(const PerspectiveCamera& camera, const Pose& eye, const Pose& source);

    /// Direction of a pixel's centre with planar depth 1, in the source's frame: corner + x right + y down.
    glm::vec3 corner() const { return corner_; }
    glm::vec3 right() const { return right_; }
    glm::vec3 down() const { return down_; }
    glm::vec3 direction(int x, int y) const { return corner_ + right_ * float(x) + down_ * float(y); }
    /// Its length: radial over planar depth.
    float length(int x, int y) const {
        const float a = (float(x) - centre_x_) * inverse_focal_;
        const float b = (float(y) - centre_y_) * inverse_focal_;
        return std::sqrt(1 + a * a + b * b);
    }
    /// The eye in the source's frame, and the same in the eye's own axes, metres.
    glm::vec3 eye() const { return eye_; }
    glm::vec3 eye_own_axes() const { return eye_own_axes_; }
    const glm::mat3& source_from_eye() const { return source_from_eye_; }
    /// Pixels: of the view, and its middle as an index of pixels.
    float focal_px() const { return focal_; }
    float centre_x() const { return centre_x_; }
    float centre_y() const { return centre_y_; }
    float distance_m() const { return glm::length(eye_); }

    /// The surface's plane at a pixel, from the inverse planar depths around it, in the source's frame and for
    /// distances from the source's centre: 1 / r(q) = m . q. Of the neighbours on either side the one nearer in depth
    /// is believed.
    glm::vec3 inverse_distance_gradient(const FloatImage& inverse_planar, int x, int y) const;

    /// Whether the source sees the back of what the eye sees: it lies beyond the surface's plane, whichever neighbours
    /// the plane is laid through. (Only thin surfaces, such as leaves, are seen from both sides at one depth.)
    bool shows_back_to_source(const FloatImage& inverse_planar, int x, int y) const;

private:
    glm::vec3 corner_, right_, down_, eye_;
    glm::vec3 eye_own_axes_;  ///< from the source's centre to the eye, in the eye's frame
    glm::mat3 source_from_eye_{1};
    float focal_ = 1, inverse_focal_ = 1, centre_x_ = 0, centre_y_ = 0;
};

}  // namespace equistream
