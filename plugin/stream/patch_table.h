#pragma once
/// A PatchAtlas as the bytes that travel with each of its pictures (docs/stream-format.md, "Patches"): some 17 bits a
/// slot, and one bit where a patch lies right below the one in the slot before.
#include <equistream/patches.h>

#include <cstdint>
#include <span>
#include <vector>

namespace equistream {

/// Throws InputError for an atlas that is not sound.
std::vector<std::uint8_t> pack_patch_table(const PatchAtlas& atlas);

/// `sphere` is the camera of the same frame data. Throws WorkError for bytes that no atlas was packed into.
PatchAtlas unpack_patch_table(std::span<const std::uint8_t> bytes, const EquirectCamera& sphere);

}  // namespace equistream
