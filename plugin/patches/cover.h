#pragma once
/// Greedy maximum coverage: blocks by what they add to what is covered.
#include "gap_samples.h"

#include <functional>

namespace equistream {

struct CoverLimits {
    std::size_t max_blocks = 0;
    std::size_t block_count = 0;  ///< ids are below this
};

/// Blocks in the order they were chosen, until there are `max_blocks` or none adds anything. `preference` (1 for most)
/// multiplies what a block adds when it is compared with others.
std::vector<BlockId> choose_blocks(const GapSamples& samples, const CoverLimits& limits,
                                   const std::function<float(BlockId)>& preference);

/// Weight of the samples that these blocks cover.
double covered_weight(const GapSamples& samples, std::span<const BlockId> blocks, std::size_t block_count);
/// Weight of the samples that any block covers.
double coverable_weight(const GapSamples& samples);

}  // namespace equistream
