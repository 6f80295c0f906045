#pragma once
/// Which slot each chosen block gets.
#include <equistream/patches.h>

#include <vector>

namespace equistream {

/// Puts the chosen blocks into the slots of `atlas`, which come from the frame before (or are all unused): blocks that
/// are there already stay, those no longer chosen go, new ones go right after the block above theirs where that slot is
/// free, else into the first free one. There must be enough slots. Returns how many stayed.
std::size_t assign_slots(std::vector<PatchAtlas::Slot> chosen, PatchAtlas& atlas);

}  // namespace equistream
