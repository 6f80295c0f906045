#pragma once
#include "fill.h"

#include <algorithm>
#include <cmath>

namespace equistream {

/// The nearest filled neighbours.
class SpreadPass : public FillPass {
public:
    std::string_view name() const override { return "spread"; }
    bool wants_depth() const override { return false; }
    void set_frame(const FillInputs&) override {}
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;
};

// How much the `spread` fill pass takes a gap pixel and its neighbour for one surface, by their depths.

/// Depths whose ratio is below about 1.1 are one surface, whatever the head box: what colours come from is a guess
/// anyway, which the bound says nothing of.
inline constexpr float same_surface_likeness = 0.1f;
/// By which squares of depths' relative differences count.
inline constexpr float likeness_steepness = 1e3f;
/// Where one of both is infinite, or not known.
inline constexpr float min_likeness = 1e-6f;

/// 1 at the same depth, less the more the depths' ratio differs from one; never quite 0.
inline float depth_likeness(float a_m, float b_m) {
    if (a_m == b_m)
        return 1;
    const float difference = std::abs(a_m - b_m) / std::min(a_m, b_m);
    return std::isfinite(difference) ? 1 / (1 + likeness_steepness * difference * difference) : min_likeness;
}

}  // namespace equistream
