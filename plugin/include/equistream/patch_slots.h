#pragma once
/// The way back from a pixel of an auxiliary sphere to the atlas of patches (patches.h). Immutable once made, so any
/// number of threads may ask.
#include <equistream/patches.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace equistream {

/// Which slot shows a block. Eight bytes for each slot
/// and four for each row of blocks, however large the spheres are said to be; of a block that is in two slots the
/// first counts.
class PatchSlots {
public:
    /// The atlas must be sound (patch_atlas_problem); it is not kept.
    explicit PatchSlots(const PatchAtlas& atlas)
        : block_rows_(atlas.block_rows()), side_(atlas.block_side), columns_(atlas.columns),
          row_ends_(atlas.offsets_m.size() * static_cast<std::size_t>(block_rows_) + 1, 0) {
        // Sorted by row, by counting; then each row by column.
        for (const PatchAtlas::Slot& slot : atlas.slots)
            if (slot.used)
                ++row_ends_[row_of(slot.offset_index, slot.block_y) + 1];
        for (std::size_t row = 1; row < row_ends_.size(); ++row)
            row_ends_[row] += row_ends_[row - 1];
        blocks_.resize(row_ends_.back());
        std::vector<std::uint32_t> next(row_ends_.begin(), row_ends_.end() - 1);
        for (std::size_t i = 0; i < atlas.slots.size(); ++i)
            if (const PatchAtlas::Slot& slot = atlas.slots[i]; slot.used)
                blocks_[next[row_of(slot.offset_index, slot.block_y)]++] = {slot.block_x, static_cast<int>(i)};
        for (std::size_t row = 0; row + 1 < row_ends_.size(); ++row)
            std::sort(blocks_.begin() + row_ends_[row], blocks_.begin() + row_ends_[row + 1]);
    }

    /// -1 where no slot shows the block.
    int slot_of(int offset_index, int block_x, int block_y) const {
        const Block* found = first_from(offset_index, block_x, block_y);
        return found != nullptr && found->x == block_x ? found->slot : -1;
    }
    /// Whether a slot shows any of the blocks from `first_x` to `last_x` of a row.
    bool shows_any(int offset_index, int first_x, int last_x, int block_y) const {
        const Block* found = first_from(offset_index, first_x, block_y);
        return found != nullptr && found->x <= last_x;
    }

    struct AtlasPixel {
        int x, y;
    };

    /// The atlas pixel that shows pixel (x, y), within the grid, of auxiliary sphere `offset_index`.
    std::optional<AtlasPixel> atlas_pixel(int offset_index, int x, int y) const {
        const int slot = slot_of(offset_index, x / side_, y / side_);
        if (slot < 0)
            return std::nullopt;
        return AtlasPixel{slot % columns_ * side_ + x % side_, slot / columns_ * side_ + y % side_};
    }

private:
    struct Block {
        int x = 0, slot = 0;
        bool operator<(const Block& other) const { return x != other.x ? x < other.x : slot < other.slot; }
    };

    std::size_t row_of(int offset_index, int block_y) const {
        return static_cast<std::size_t>(offset_index) * static_cast<std::size_t>(block_rows_) +
               static_cast<std::size_t>(block_y);
    }
    /// Of a row's blocks the first one at `block_x` or to the right; null where there is none.
    const Block* first_from(int offset_index, int block_x, int block_y) const {
        const std::size_t row = row_of(offset_index, block_y);
        const Block* const end = blocks_.data() + row_ends_[row + 1];
        const Block* const found = std::lower_bound(blocks_.data() + row_ends_[row], end, Block{block_x, 0});
        return found == end ? nullptr : found;
    }

    int block_rows_, side_, columns_;
    std::vector<std::uint32_t> row_ends_;  ///< of each sphere's row, in blocks_; before the first one 0
    std::vector<Block> blocks_;
};

}  // namespace equistream
