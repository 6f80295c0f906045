#pragma once
/// Which blocks an atlas takes: greedy maximum coverage, each by what it adds to what is covered.
#include "gap_samples.h"

#include <equistream/patches.h>

#include <functional>
#include <vector>

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

// Which slot each chosen block gets.

/// Puts the chosen blocks into the slots of `atlas`, which come from the frame before (or are all unused): blocks that
/// are there already stay, those no longer chosen go, new ones go right after the block above theirs where that slot is
/// free, else into the first free one. There must be enough slots. Returns how many stayed.
std::size_t assign_slots(std::vector<PatchAtlas::Slot> chosen, PatchAtlas& atlas);

}  // namespace equistream
