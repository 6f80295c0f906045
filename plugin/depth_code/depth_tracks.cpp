#include <equistream/bound.h>
#include <equistream/depth_code.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace equistream {

namespace {

/// The nearest depth whose w is `w`.
double distance_of(double w, double box_radius_m) {
    return box_radius_m * (1 + 1 / w);
}

}  // namespace

double quantisation_bound_rad(const DepthCode& code, const DepthRange& range) {
    const double nearest_w = bounded_inverse_depth(range.near_m, range.box_radius_m);
    return std::asin(std::min(1.0, nearest_w * code.max_error(range)));
}

double depth_tolerance_w(const std::optional<DepthCodeInfo>& code) {
    return code ? std::sin(quantisation_bound_rad(*make_depth_code(code->code), code->range)) : 0;
}

DepthRange depth_range(const DepthCode& code, double box_radius_m, double nearest_m, bool has_empty,
                       double focal_length_px) {
    assert(box_radius_m > 0 && focal_length_px > 0);
    DepthRange range{box_radius_m, 0, has_empty};
    // Half a step may be no more than the budget; without a step there is nothing to hold but that near is outside.
    const int levels = std::max(code.levels(range), 1);
    const double max_w = code.levels(range) == 0 ? 1 : 2 * levels * error_budget_rad(focal_length_px);
    // Rounded up to a float, which depths are, and out of the box for good.
    const double held =
        static_cast<double>(std::nextafter(static_cast<float>(distance_of(max_w, box_radius_m)), HUGE_VALF));
    // Where nothing is hit, any depth will do.
    range.near_m = std::isfinite(nearest_m) ? std::max(nearest_m, held) : held;
    return range;
}

DepthCodeId code_for_bound(double box_radius_m, double nearest_m, bool has_empty, double focal_length_px) {
    for (const DepthCodeId id : {DepthCodeId::w8, DepthCodeId::w10}) {
        const auto code = make_depth_code(id);
        const DepthRange range{box_radius_m, std::max(nearest_m, std::nextafter(box_radius_m, HUGE_VAL)), has_empty};
        if (quantisation_bound_rad(*code, range) <= default_budget_share * error_budget_rad(focal_length_px))
            return id;
    }
    return DepthCodeId::w12;
}

FloatImage halve_depth(ImageView<const float> depth_m) {
    assert(depth_m.channels == 1 && depth_m.width % 2 == 0 && depth_m.height % 2 == 0);
    FloatImage half_m(depth_m.width / 2, depth_m.height / 2, 1);
    tbb::parallel_for(0, half_m.height(), [&](int y) {
        const float* upper = depth_m.row(2 * y);
        const float* lower = depth_m.row(2 * y + 1);
        float* half = half_m.pixel(0, y);
        // fmin passes NaN by.
        for (int x = 0; x < half_m.width(); ++x)
            half[x] = std::fmin(std::fmin(upper[2 * x], upper[2 * x + 1]), std::fmin(lower[2 * x], lower[2 * x + 1]));
    });
    return half_m;
}

FloatImage double_depth(ImageView<const float> half_m) {
    assert(half_m.channels == 1);
    FloatImage depth_m(half_m.width * 2, half_m.height * 2, 1);
    tbb::parallel_for(0, half_m.height, [&](int y) {
        const float* half = half_m.row(y);
        for (int row = 2 * y; row < 2 * y + 2; ++row)
            for (int x = 0; x < half_m.width; ++x)
                depth_m.pixel(2 * x, row)[0] = depth_m.pixel(2 * x, row)[1] = half[x];
    });
    return depth_m;
}

}  // namespace equistream
