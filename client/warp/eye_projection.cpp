#include "eye_projection.h"

#include <algorithm>

namespace equistream {

namespace {

Vec3f to_float(const glm::dvec3& v) {
    return {float(v.x), float(v.y), float(v.z)};
}

glm::dvec3 eye_in_source(const Pose& eye, const Pose& source) {
    return glm::conjugate(source.orientation) * (eye.position_m - source.position_m);
}

}  // namespace

EyeProjection::EyeProjection(const PerspectiveCamera& camera, const Pose& eye, const Pose& source)
    : eye_(to_float(eye_in_source(eye, source))), width_(camera.width), height_(camera.height) {
    const glm::dquat source_from_eye = glm::conjugate(source.orientation) * eye.orientation;
    const glm::dvec3 right = source_from_eye * glm::dvec3(1, 0, 0);
    const glm::dvec3 up = source_from_eye * glm::dvec3(0, 1, 0);
    const glm::dvec3 forward = source_from_eye * glm::dvec3(0, 0, -1);
    const double focal = camera.focal_px();
    x_ = to_float(focal * right + (0.5 * camera.width - 0.5) * forward);
    y_ = to_float(-focal * up + (0.5 * camera.height - 0.5) * forward);
    forward_ = to_float(forward);
}

void EyeProjection::project(const LatticeBlock& block, ProjectedBlock& out) const {
    const Vec3f eye = eye_, across = x_, down = y_, forward = forward_;
    for (int i = 0; i < LatticeBlock::stride * LatticeBlock::stride; ++i) {
        const float k = block.k[i];
        const float ex = block.qx[i] - k * eye.x, ey = block.qy[i] - k * eye.y, ez = block.qz[i] - k * eye.z;
        const float z = forward.x * ex + forward.y * ey + forward.z * ez;
        const float scale = 1 / z;
        out.x[i] = (across.x * ex + across.y * ey + across.z * ez) * scale;
        out.y[i] = (down.x * ex + down.y * ey + down.z * ez) * scale;
        out.inverse_planar[i] = k * scale;
        out.forward[i] = z;
    }
}

SeenThrough::SeenThrough(const PerspectiveCamera& camera, const Pose& eye, const Pose& source, PixelBox box) {
    const glm::dquat source_from_eye = glm::conjugate(source.orientation) * eye.orientation;
    const glm::dvec3 position = eye_in_source(eye, source);
    const glm::dvec3 corners[4] = {camera.direction(box.x0, box.y0), camera.direction(box.x1, box.y0),
                                   camera.direction(box.x1, box.y1), camera.direction(box.x0, box.y1)};
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 n = glm::normalize(source_from_eye * glm::cross(corners[i], corners[(i + 1) % 4]));
        planes_[i] = {to_float(n), float(glm::dot(n, position))};
    }
}

bool SeenThrough::may_show(const SourceLattice::Summary& block) const {
    return std::ranges::all_of(planes_, [&](const Plane& plane) {
        // The largest inwards . q over the block's cone, less the smallest k inwards . eye.
        const float cosine = dot(plane.inwards, block.axis);
        const float sine = std::sqrt(std::max(1 - cosine * cosine, 0.0f));
        const float largest = cosine >= block.cos_radius ? 1 : cosine * block.cos_radius + sine * block.sin_radius;
        const float least = std::min(block.nearest_inverse_m * plane.at_eye, block.farthest_inverse_m * plane.at_eye);
        return largest - least >= -1e-5f;
    });
}

}  // namespace equistream
