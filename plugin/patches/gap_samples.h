#pragma once
/// What training eyes see and the sphere's centre does not, and which blocks of auxiliary spheres show it.
#include "depth_sphere.h"

#include <cstdint>
#include <span>
#include <vector>

namespace equistream {

/// Which block of which auxiliary sphere: (sphere * block rows + row) * block columns + column.
using BlockId = std::uint32_t;

/// Gap samples and, for each, the blocks that cover it.
struct GapSamples {
    std::vector<float> weight;         ///< solid angle in its eye
    std::vector<std::uint32_t> first;  ///< into `blocks`; one more than there are samples
    std::vector<BlockId> blocks;
    double tried = 0;  ///< weight of all points that were looked at
};

struct GapRule {
    double box_radius_m = 0;
    double tolerance_rad = 0;
    int block_side = 16;
    double weight = 1;  ///< how much the eye counts
    int stride = 2;     ///< every so many columns and rows of the eye
};

/// Appends the gap samples of one training eye. All spheres have the same camera.
void append_gap_samples(const DepthSphere& eye, const DepthSphere& centre, std::span<const DepthSphere> auxiliary,
                        const GapRule& rule, GapSamples& samples);

}  // namespace equistream
