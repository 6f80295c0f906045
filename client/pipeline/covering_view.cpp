#include "covering_view.h"

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

constexpr double widest_rad = 85 * pi / 180, min_tangent = 1e-3;
/// Angles come in single precision: what ends so little beyond a pixel ends at it.
constexpr double edge_px = 1e-3;

double tangent(double angle_rad) {
    return std::tan(std::clamp(angle_rad, -widest_rad, widest_rad));
}

/// The whole pixels between two places, from `middle` on, and where they end.
struct Span {
    Span(double low_px, double high_px, int size) {
        const double middle = 0.5 * size;
        first = std::clamp(int(std::floor(middle + low_px + edge_px)), 0, size - 1);
        end = std::clamp(int(std::ceil(middle + high_px - edge_px)), first + 1, size);
        low = first - middle;
        high = end - middle;
    }
    int first, end;
    double low, high;
};

}  // namespace

CoveringView covering_view(const std::array<FieldOfView, 2>& eyes, int columns, ViewSize most) {
    double across = min_tangent, down = min_tangent;
    for (const FieldOfView& eye : eyes) {
        across = std::max({across, std::abs(tangent(eye.left_rad)), std::abs(tangent(eye.right_rad))});
        down = std::max({down, std::abs(tangent(eye.up_rad)), std::abs(tangent(eye.down_rad))});
    }
    const double left_eye = std::max(min_tangent, tangent(eyes[0].right_rad) - tangent(eyes[0].left_rad));
    const double focal_px =
        std::min({columns / left_eye, 0.5 * most.width / across - 0.5, 0.5 * most.height / down - 0.5});
    CoveringView view;
    view.camera.width = std::clamp(2 * int(std::ceil(focal_px * across - edge_px)), 2, most.width);
    view.camera.height = std::clamp(2 * int(std::ceil(focal_px * down - edge_px)), 2, most.height);
    view.camera.fov_x_rad = 2 * std::atan(0.5 * view.camera.width / focal_px);
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        const Span x(focal_px * tangent(eyes[i].left_rad), focal_px * tangent(eyes[i].right_rad), view.camera.width);
        const Span y(-focal_px * tangent(eyes[i].up_rad), -focal_px * tangent(eyes[i].down_rad), view.camera.height);
        view.parts[i] = {x.first,
                         y.first,
                         x.end - x.first,
                         y.end - y.first,
                         {std::atan(x.low / focal_px), std::atan(x.high / focal_px), std::atan(-y.low / focal_px),
                          std::atan(-y.high / focal_px)}};
    }
    return view;
}

}  // namespace equistream
