#include "hiding_surface.h"

#include <cmath>

namespace equistream {

namespace {

/// The largest second difference along a row or column, or across the inner four; NaN stays.
float largest_bend(const std::array<float, 16>& values) {
    float largest = std::abs((values[5] - values[6]) - (values[9] - values[10]));
    const auto add = [&](int before, int middle, int after) {
        const float bend = std::abs(values[before] - 2 * values[middle] + values[after]);
        largest = bend <= largest ? largest : bend;
    };
    for (int line = 0; line < 4; ++line)
        for (int i = 1; i < 3; ++i) {
            add(4 * line + i - 1, 4 * line + i, 4 * line + i + 1);
            add(4 * (i - 1) + line, 4 * i + line, 4 * (i + 1) + line);
            if (std::isnan(largest))
                return largest;
        }
    return largest;
}

/// Beyond a pole the rows come back on the other side.
Sample wrapped_far(const SourceGrid& grid, int x, int y) {
    if (y < -1 && grid.north_pole)
        return wrapped(grid, x + grid.width / 2, -1 - y, grid.width, grid.height);
    if (y > grid.height && grid.south_pole)
        return wrapped(grid, x + grid.width / 2, 2 * grid.height - 1 - y, grid.width, grid.height);
    return wrapped(grid, x, y, grid.width, grid.height);
}

}  // namespace

bool surface_hides(const DepthAgreement& agreement, const std::array<float, 16>& over_reach, float s, float t,
                   float point_over_reach) {
    const auto& k = over_reach;
    const float upper = k[5] + s * (k[6] - k[5]), lower = k[9] + s * (k[10] - k[9]);
    const float behind = agreement.box_radius_m * (upper + t * (lower - upper) - point_over_reach);
    if (!(behind > agreement.tolerance))
        return false;
    const float bend = agreement.box_radius_m * largest_bend(over_reach);
    // An eighth of the bend is what linear interpolation may be off by.
    return bend <= 8 * agreement.tolerance && behind > agreement.tolerance + 0.5f * bend * (s * (1 - s) + t * (1 - t));
}

bool surface_hides(const DepthAgreement& agreement, const SourceGrid& grid, const ImageView<const float>& depth_m,
                   int u, int v, float point_over_reach) {
    const int x0 = u >> position_bits, y0 = v >> position_bits;
    std::array<float, 16> over_reach;
    for (int i = 0; i < 16; ++i) {
        const Sample sample = wrapped_far(grid, x0 - 1 + i % 4, y0 - 1 + i / 4);
        const float distance_m = depth_m.pixel(sample.x, sample.y)[0];
        over_reach[std::size_t(i)] = distance_m > 0 ? 1 / agreement.reach(distance_m) : std::nanf("");
    }
    const auto fraction = [](int position) { return float(position & (position_one - 1)) / position_one; };
    return surface_hides(agreement, over_reach, fraction(u), fraction(v), point_over_reach);
}

}  // namespace equistream
