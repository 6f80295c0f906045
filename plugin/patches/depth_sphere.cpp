#include "depth_sphere.h"

namespace equistream {
namespace {

double inverse(float depth_m) {
    return 1 / std::min<double>(depth_m, far_distance_m);
}

}  // namespace

DepthSphere::DepthSphere(const EquirectCamera& camera, const glm::dvec3& offset_m)
    : camera_(camera), offset_m_(offset_m), depth_m_(camera.width, camera.height, 1) {
    const LongitudeLatitudeRange& range = camera.range;
    for (int x = 0; x < camera.width; ++x) {
        const double l = range.longitude_min + (x + 0.5) * range.longitude_span() / camera.width;
        longitude_.emplace_back(std::sin(l), std::cos(l));
    }
    for (int y = 0; y < camera.height; ++y) {
        const double p = range.latitude_max - (y + 0.5) * range.latitude_span() / camera.height;
        latitude_.emplace_back(std::sin(p), std::cos(p));
    }
}

int DepthSphere::wrapped_column(int x) const {
    if (!camera_.range.closes())
        return std::clamp(x, 0, camera_.width - 1);
    return x < 0 ? x + camera_.width : x >= camera_.width ? x - camera_.width : x;
}

glm::dvec3 DepthSphere::direction(int x, int y) const {
    const glm::dvec2 l = longitude_[static_cast<std::size_t>(wrapped_column(x))];
    const glm::dvec2 p = latitude_[static_cast<std::size_t>(y)];
    return {p.y * l.x, p.x, -p.y * l.y};
}

SurfacePoint DepthSphere::point(int x, int y) const {
    const double r = std::min<double>(depth_m_.pixel(x, y)[0], far_distance_m);
    return {offset_m_ + r * direction(x, y), glm::dvec3(0), offset_m_};
}

glm::dvec3 DepthSphere::plane(int x, int y) const {
    const double here = inverse(depth_m_.pixel(x, y)[0]);
    const auto at = [&](int column, int row) { return inverse(depth_m_.pixel(wrapped_column(column), row)[0]); };
    const double left = at(x - 1, y), right = at(x + 1, y);
    const int dx = std::abs(left - here) < std::abs(right - here) ? -1 : 1;
    int dy = y + 1 < camera_.height ? 1 : -1;
    if (y > 0 && y + 1 < camera_.height && std::abs(at(x, y - 1) - here) < std::abs(at(x, y + 1) - here))
        dy = -1;
    // 1/r(q) = m . q through three pixels, by Cramer's rule.
    const glm::dvec3 q0 = direction(x, y), q1 = direction(x + dx, y), q2 = direction(x, y + dy);
    const glm::dvec3 across = glm::cross(q1, q2);
    const double determinant = glm::dot(q0, across);
    if (std::abs(determinant) < 1e-14)
        return q0 * here;
    return (here * across + (dx < 0 ? left : right) * glm::cross(q2, q0) + at(x, y + dy) * glm::cross(q0, q1)) /
           determinant;
}

SeenTaps DepthSphere::seen(const SurfacePoint& point, const DepthAgreement& agreement) const {
    const glm::dvec3 to_point = point.position_m - offset_m_;
    const glm::dvec2 at = camera_.pixel(to_point);
    SeenTaps taps;
    const double at_here = 1 - glm::dot(point.plane, offset_m_ - point.eye_m);
    if (at_here <= 0)  // the surface turns its back to this sphere
        return taps;
    const glm::dvec2 corner = glm::floor(at - 0.5);
    if (!(at.x >= 0 && at.x <= camera_.width && at.y >= 0 && at.y <= camera_.height))
        return taps;
    const glm::dvec2 f = at - 0.5 - corner;
    const float reach = agreement.clearance(static_cast<float>(glm::length(to_point)));
    for (std::size_t k = 0; k < 4; ++k) {
        const int right = static_cast<int>(k & 1), down = static_cast<int>(k >> 1);
        taps.x[k] = wrapped_column(static_cast<int>(corner.x) + right);
        taps.y[k] = std::clamp(static_cast<int>(corner.y) + down, 0, camera_.height - 1);
        const float sample = agreement.clearance(depth_m_.pixel(taps.x[k], taps.y[k])[0]);
        bool same = agreement.same(reach, sample);
        if (!same && point.plane != glm::dvec3(0)) {
            const double inverse_distance = glm::dot(point.plane, direction(taps.x[k], taps.y[k])) / at_here;
            const double predicted =
                inverse_distance > 1 / double{far_distance_m} ? 1 / inverse_distance : far_distance_m;
            same = agreement.between(reach, agreement.clearance(static_cast<float>(predicted)), sample);
        }
        if (same)
            taps.weight[k] = static_cast<float>((right ? f.x : 1 - f.x) * (down ? f.y : 1 - f.y));
    }
    return taps;
}

}  // namespace equistream
