#include "covering_view.h"

#include <algorithm>
#include <cassert>
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

/// Of both eyes' fields of view, at a focal length of 1.
struct Extent {
    explicit Extent(const std::array<FieldOfView, 2>& eyes) {
        for (const FieldOfView& eye : eyes) {
            const double left = tangent(eye.left_rad), right = tangent(eye.right_rad), up = tangent(eye.up_rad),
                         down = tangent(eye.down_rad);
            reach_x = std::max({reach_x, std::abs(left), std::abs(right)});
            reach_y = std::max({reach_y, std::abs(up), std::abs(down)});
            width = std::max(width, right - left);
            height = std::max(height, up - down);
        }
    }
    double longest_focal_px(ViewSize most) const {
        return std::min(0.5 * most.width / reach_x - 0.5, 0.5 * most.height / reach_y - 0.5);
    }
    double reach_x = min_tangent, reach_y = min_tangent;  ///< from the middle to the farthest edge
    double width = min_tangent, height = min_tangent;     ///< of the wider eye, and of the higher one
};

/// Pixels from edge to edge of a symmetric view. `odd`: 1 where its middle lies within a pixel, 0 between two.
int side_of(double reach_px, int odd, int most) {
    return std::clamp(2 * int(std::ceil(reach_px - edge_px - 0.5 * odd)) + odd, 2 - odd, most);
}

/// `odd`: of each side, as side_of has it.
CoveringView view_of(const std::array<FieldOfView, 2>& eyes, double focal_px, ViewSize odd, ViewSize most) {
    const Extent extent(eyes);
    CoveringView view;
    view.camera.width = side_of(focal_px * extent.reach_x, odd.width, most.width);
    view.camera.height = side_of(focal_px * extent.reach_y, odd.height, most.height);
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

bool fits(const CoveringView& view, ViewSize room) {
    return std::ranges::all_of(
        view.parts, [&](const ViewPart& part) { return part.width <= room.width && part.height <= room.height; });
}

/// The focal length at which `side` pixels always suffice. Either one pixel is spare, or they hold the whole symmetric
/// view.
double sure_focal_px(int side, double across, double reach) {
    return std::max((side - 1) / across, 0.5 * side / reach);
}

}  // namespace

CoveringView covering_view(const std::array<FieldOfView, 2>& eyes, int columns, ViewSize most) {
    const double left_eye = std::max(min_tangent, tangent(eyes[0].right_rad) - tangent(eyes[0].left_rad));
    return view_of(eyes, std::min(columns / left_eye, Extent(eyes).longest_focal_px(most)), {0, 0}, most);
}

CoveringView fitted_view(const std::array<FieldOfView, 2>& eyes, ViewSize room, ViewSize most) {
    const Extent extent(eyes);
    const ViewSize odd{room.width % 2, room.height % 2};
    double focal_px = room.width / extent.width;
    if (focal_px * extent.height > room.height + edge_px)
        focal_px = room.height / extent.height;
    focal_px = std::min(focal_px, extent.longest_focal_px(most));
    CoveringView view = view_of(eyes, focal_px, odd, most);
    if (fits(view, room))
        return view;
    focal_px = std::min({focal_px, sure_focal_px(room.width, extent.width, extent.reach_x),
                         sure_focal_px(room.height, extent.height, extent.reach_y)});
    view = view_of(eyes, focal_px, odd, most);
    assert(fits(view, room));
    return view;
}

}  // namespace equistream
