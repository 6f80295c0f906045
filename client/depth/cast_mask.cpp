#include "cast_mask.h"

#include <atomic>
#include <cmath>

namespace equistream {

void CastMask::mark(int y, int first, int last, const EquirectCamera& camera) {
    std::uint8_t* marks = row(y);
    const auto set = [&](int x) { std::atomic_ref<std::uint8_t>(marks[x]).store(1, std::memory_order_relaxed); };
    last = std::min(last, first + camera.width - 1);
    for (int x = first; x <= last; ++x) {
        if (x >= 0 && x < camera.width)
            set(x);
        else if (camera.range.closes())
            set((x % camera.width + camera.width) % camera.width);
    }
}

void CastMask::mark_ball(const MoverBall& ball, const EquirectCamera& camera, const Pose& pose) {
    const glm::dvec3 towards = glm::conjugate(pose.orientation) * (ball.centre_m - pose.position_m);
    const double distance_m = glm::length(towards);
    if (distance_m <= ball.radius_m)
        return set_all(1);
    const double pixel = camera.range.latitude_span() / camera.height;
    const double angle = std::asin(ball.radius_m / distance_m) + 2 * pixel;
    const double latitude = std::asin(std::clamp(towards.y / distance_m, -1.0, 1.0));
    const glm::dvec2 middle = camera.pixel(towards);
    const bool over_pole = std::abs(latitude) + angle >= 0.5 * pi;
    const double half_width = over_pole ? camera.width
                                        : std::asin(std::min(1.0, std::sin(angle) / std::cos(latitude))) *
                                              camera.width / camera.range.longitude_span();
    const double half_height = angle / pixel;
    const int first = std::max(0, int(std::floor(middle.y - half_height)));
    const int last = std::min(camera.height - 1, int(std::ceil(middle.y + half_height)));
    for (int y = first; y <= last; ++y)
        mark(y, int(std::floor(middle.x - half_width)) - 1, int(std::ceil(middle.x + half_width)) + 1, camera);
}

}  // namespace equistream
