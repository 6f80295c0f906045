// The test of hiding.glsl.h for positions whose sixteen samples lie in the picture: rows of four as registers.
#if defined(EQUISTREAM_HIDING_SURFACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_HIDING_SURFACE_INL_H
#undef EQUISTREAM_HIDING_SURFACE_INL_H
#else
#define EQUISTREAM_HIDING_SURFACE_INL_H
#endif

#include "resample.h"

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// Where a position lies among the sixteen samples, and what is asked of them.
struct HiddenPoint {
    float s = 0, t = 0, over_clearance = 0;
};

/// `first` is the first of the sixteen, rows `stride` apart.
HWY_INLINE bool surface_hides(const DepthAgreement& agreement, const float* first, std::ptrdiff_t stride,
                              const HiddenPoint& point) {
    namespace hn = hwy::HWY_NAMESPACE;
    const hn::FixedTag<float, 4> four;
    using Four = hn::Vec<decltype(four)>;
    const float budget = agreement.tolerance / agreement.box_radius_m;
    const float most = max_bend * budget;
    const auto row_at = [&](int j) HWY_ATTR {
        // clearance_of(), four at a time.
        const Four far = hn::Set(four, far_distance_m), distance_m = hn::LoadU(four, first + j * stride);
        const Four r = hn::IfThenElse(distance_m > far, far, distance_m);
        const Four share = hn::Set(four, equistream::formulas::min_clearance_share);
        return hn::Set(four, 1.0f) / hn::Max(share * r, r - hn::Set(four, agreement.box_radius_m));
    };
    // Silhouettes mostly end here: the upper three rows, in columns.
    Four rows[4] = {row_at(0), row_at(1), row_at(2)};
    if (!hn::AllTrue(four, hn::Abs((rows[2] - rows[1]) - (rows[1] - rows[0])) <= hn::Set(four, most)))
        return false;
    rows[3] = row_at(3);
    float across = 0;
    for (int j = 0; j < 4; ++j) {
        const Four step = hn::Shuffle0321(rows[j]) - rows[j];
        const Four second = hn::Abs(hn::Shuffle0321(step) - step);
        const float left = hn::GetLane(second), right = hn::GetLane(hn::Shuffle0321(second));
        if (!(left <= most && right <= most))
            return false;
        if (j == 1 || j == 2)
            across = std::max(across, left + right);
    }
    const Four upper = rows[1] - rows[0], middle = rows[2] - rows[1], lower = rows[3] - rows[2];
    const Four twist = hn::Abs(hn::Shuffle0321(middle) - middle);
    const Four above = hn::Abs(middle - upper), below = hn::Abs(lower - middle);
    const Four down = hn::Shuffle0321(above + below);
    if (!hn::AllTrue(four, hn::Max(above, below) <= hn::Set(four, most)) ||
        !(hn::GetLane(hn::Shuffle0321(twist)) <= most))
        return false;
    const Four row = hn::MulAdd(hn::Set(four, point.t), middle, rows[1]);
    const Four here = hn::MulAdd(hn::Set(four, point.s), hn::Shuffle0321(row) - row, row);
    const float behind = hn::GetLane(hn::Shuffle0321(here)) - point.over_clearance;
    const float larger_down = std::max(hn::GetLane(down), hn::GetLane(hn::Shuffle0321(down)));
    return behind > min_behind * budget + across * point.s * (1 - point.s) + larger_down * point.t * (1 - point.t);
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
