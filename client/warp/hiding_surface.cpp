#include "hiding_surface.h"

#include <cmath>

namespace equistream {

namespace {

/// Second differences of sixteen values.
struct Bends {
    float largest = 0;           ///< along a row or column, or across the inner four
    float across = 0, down = 0;  ///< sums of the two along the inner four's rows and columns, the larger one

    explicit Bends(const std::array<float, 16>& values) {
        largest = std::abs((values[5] - values[6]) - (values[9] - values[10]));
        for (int line = 0; line < 4; ++line) {
            const float of_row = sum_along(values, 4 * line, 1), of_column = sum_along(values, line, 4);
            if (line == 1 || line == 2) {
                across = std::max(across, of_row);
                down = std::max(down, of_column);
            }
        }
    }

private:
    float sum_along(const std::array<float, 16>& values, int first, int step) {
        float sum = 0;
        for (const int i : {first, first + step}) {
            const float bend = std::abs(values[i] - 2 * values[i + step] + values[i + 2 * step]);
            largest = bend <= largest || std::isnan(largest) ? largest : bend;
            sum += bend;
        }
        return sum;
    }
};

}  // namespace

bool surface_hides(const DepthAgreement& agreement, const std::array<float, 16>& over_clearance, float s, float t,
                   float point_over_clearance) {
    const auto& k = over_clearance;
    const float upper = k[5] + s * (k[6] - k[5]), lower = k[9] + s * (k[10] - k[9]);
    const float behind = agreement.box_radius_m * (upper + t * (lower - upper) - point_over_clearance);
    if (!(behind > min_behind * agreement.tolerance))
        return false;
    const Bends bends(over_clearance);
    const float off = bends.across * s * (1 - s) + bends.down * t * (1 - t);
    return agreement.box_radius_m * bends.largest <= max_bend * agreement.tolerance &&
           behind > min_behind * agreement.tolerance + agreement.box_radius_m * off;
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
