#include "hiding_surface.h"

#include <cmath>

namespace equistream {

bool surface_hides(const DepthAgreement& agreement, const std::array<float, 16>& over_clearance, float s, float t,
                   float point_over_clearance) {
    return formulas::surface_hides(over_clearance.data(), s, t, point_over_clearance, agreement.box_radius_m,
                                   agreement.tolerance);
}

bool surface_hides(const DepthAgreement& agreement, const SourceGrid& grid, const ImageView<const float>& depth_m,
                   int u, int v, float point_over_clearance) {
    const int x0 = u >> position_bits, y0 = v >> position_bits;
    std::array<float, 16> over_clearance;
    for (int i = 0; i < 16; ++i) {
        const Sample sample = wrapped(grid, x0 - 1 + i % 4, y0 - 1 + i / 4);
        const float distance_m = depth_m.pixel(sample.x, sample.y)[0];
        over_clearance[std::size_t(i)] = distance_m > 0 ? 1 / agreement.clearance(distance_m) : std::nanf("");
    }
    const auto fraction = [](int position) { return float(position & (position_one - 1)) / position_one; };
    return surface_hides(agreement, over_clearance, fraction(u), fraction(v), point_over_clearance);
}

}  // namespace equistream
