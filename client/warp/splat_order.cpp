#include "splat_order.h"

#include <cmath>

namespace equistream {

SplatOrder::SplatOrder(const Camera& source, const glm::dvec3& eye) {
    const int width = width_of(source);
    if (const auto* sphere = std::get_if<EquirectCamera>(&source)) {
        const Vector3<double> epipole{eye.x, eye.y, eye.z};
        const double longitude_of_epipole = longitude_of(epipole);
        const double tangent = std::tan(latitude_of(epipole));
        const double rows_per_radian = sphere->height / sphere->range.latitude_span();
        for (int x = 0; x < width; ++x) {
            const double longitude = sphere->range.longitude_min + (x + 0.5) * sphere->range.longitude_span() / width;
            const double apart = std::abs(std::remainder(longitude - longitude_of_epipole, 2 * pi));
            earliness_.push_back(apart);
            turning_row_.push_back((sphere->range.latitude_max - std::atan(tangent / std::cos(apart))) *
                                   rows_per_radian);
            towards_.push_back(apart < pi / 2);
        }
        return;
    }
    // An eye beside the source has its epipole at infinity; so far away only the side counts.
    const auto& perspective = std::get<PerspectiveCamera>(source);
    const bool in_front = eye.z < 0;
    const double forward = std::max(std::abs(eye.z), 1e-9 * glm::length(eye)) * (in_front ? 1 : -1);
    const double focal = perspective.focal_px();
    const double column = 0.5 * perspective.width + focal * eye.x / forward;
    const double row = 0.5 * perspective.height - focal * eye.y / forward;
    for (int x = 0; x < width; ++x) {
        const double apart = std::abs(x + 0.5 - column);
        earliness_.push_back(in_front ? apart : -apart);
        turning_row_.push_back(row);
        towards_.push_back(in_front);
    }
}

}  // namespace equistream
