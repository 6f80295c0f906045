#pragma once
/// Server-predicted patches: surfaces that eyes in the head box see and the sphere's centre does not. They are rendered
/// from points beside the centre and packed into one picture, the atlas.
///
/// Each of `offsets_m` is the centre of an auxiliary sphere: an equirect grid of the main sphere's size, range and
/// axes. A *patch* is one block of block_side x block_side pixels of such a grid; the atlas shows patches in *slots*,
/// row by row. Pixel (x, y) of a slot that shows block (bx, by) of auxiliary sphere k is pixel (bx side + x, by side +
/// y) of that sphere: its ray starts at offsets_m[k] and its depth is the distance from there. Blocks at the right and
/// lower border may reach beyond the grid. There the image formula continues round the seam and over the pole.
///
/// A block keeps its slot for as long as it stays chosen, so that video of the atlas compresses well. Pixels of unused
/// slots have no meaning. Everything here is a plain value; all functions are pure and thread-safe.
#include <equistream/camera.h>
#include <equistream/image.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// Limits that readers check before they allocate.
inline constexpr int max_patch_offsets = 64;
inline constexpr int max_patch_slots = 12288;
inline constexpr int min_patch_side = 4, max_patch_side = 64;

struct PatchAtlas {
    /// The patch in a slot. All fields of an unused slot are 0.
    struct Slot {
        std::uint8_t offset_index = 0;           ///< in offsets_m
        std::uint16_t block_x = 0, block_y = 0;  ///< column and row in the grid of blocks
        bool used = false;

        bool operator==(const Slot&) const = default;
    };

    int sphere_width = 0, sphere_height = 0;  ///< pixels of each auxiliary sphere
    int block_side = 16;                      ///< pixels, min_patch_side to max_patch_side
    LongitudeLatitudeRange range;
    /// Centres of the auxiliary spheres, from the main sphere's centre in its camera's axes. Single precision in
    /// streams.
    std::vector<glm::dvec3> offsets_m;
    int columns = 0, rows = 0;  ///< of slots
    std::vector<Slot> slots;    ///< columns * rows, row by row

    /// Size of the atlas picture in pixels.
    int width() const { return columns * block_side; }
    int height() const { return rows * block_side; }
    /// Size of each auxiliary sphere in blocks, rounded up.
    int block_columns() const { return (sphere_width + block_side - 1) / block_side; }
    int block_rows() const { return (sphere_height + block_side - 1) / block_side; }
    EquirectCamera sphere() const { return {sphere_width, sphere_height, range}; }
    std::size_t used_slots() const {
        return static_cast<std::size_t>(
            std::count_if(slots.begin(), slots.end(), [](const Slot& slot) { return slot.used; }));
    }
    /// The slot that a pixel of the atlas picture belongs to.
    const Slot& slot_at(int x, int y) const {
        return slots[static_cast<std::size_t>(y / block_side) * static_cast<std::size_t>(columns) +
                     static_cast<std::size_t>(x / block_side)];
    }
};

/// Continuous pixel coordinates on the auxiliary sphere for atlas coordinates (u, v). Pixel (x, y) names their slot,
/// because a border belongs to two slots.
inline PixelCoordinates<double> patch_sphere_pixel(const PatchAtlas& atlas, int x, int y, double u, double v) {
    const PatchAtlas::Slot& slot = atlas.slot_at(x, y);
    const int side = atlas.block_side;
    return {u - x / side * side + slot.block_x * side, v - y / side * side + slot.block_y * side};
}

/// What is wrong with an atlas, in the form "expected ..., found ..."; nullopt if it is valid. For untrusted input.
inline std::optional<std::string> patch_atlas_problem(const PatchAtlas& a) {
    const auto differs = [](const std::string& expected, auto found) {
        return std::optional("expected " + expected + ", found " + std::to_string(found));
    };
    if (a.block_side < min_patch_side || a.block_side > max_patch_side)
        return differs("patches of " + std::to_string(min_patch_side) + " to " + std::to_string(max_patch_side) +
                           " pixels a side",
                       a.block_side);
    if (a.sphere_width < 1 || a.sphere_width > max_image_side || a.sphere_height < 1 ||
        a.sphere_height > max_image_side)
        return differs("a sphere of 1 to " + std::to_string(max_image_side) + " pixels a side",
                       std::max(a.sphere_width, a.sphere_height));
    if (!(a.range.longitude_span() > 0 && a.range.latitude_span() > 0))
        return differs("ascending longitudes and latitudes",
                       std::min(a.range.longitude_span(), a.range.latitude_span()));
    if (a.offsets_m.empty() || a.offsets_m.size() > static_cast<std::size_t>(max_patch_offsets))
        return differs("1 to " + std::to_string(max_patch_offsets) + " offsets", a.offsets_m.size());
    for (const glm::dvec3& offset : a.offsets_m)
        if (!(std::abs(offset.x) < 1e6 && std::abs(offset.y) < 1e6 && std::abs(offset.z) < 1e6))
            return differs("offsets of less than 1e6 m", std::abs(offset.x) + std::abs(offset.y) + std::abs(offset.z));
    if (a.columns < 1 || a.rows < 1 || a.columns > max_patch_slots || a.rows > max_patch_slots / a.columns)
        return differs("1 to " + std::to_string(max_patch_slots) + " slots",
                       static_cast<double>(a.columns) * static_cast<double>(a.rows));
    if (a.width() > max_image_side || a.height() > max_image_side)
        return differs("an atlas of at most " + std::to_string(max_image_side) + " pixels a side",
                       std::max(a.width(), a.height()));
    if (a.slots.size() != static_cast<std::size_t>(a.columns) * static_cast<std::size_t>(a.rows))
        return differs(std::to_string(a.columns) + " x " + std::to_string(a.rows) + " slots", a.slots.size());
    for (const PatchAtlas::Slot& slot : a.slots) {
        if (!slot.used)
            continue;
        if (slot.offset_index >= a.offsets_m.size())
            return differs("an offset below " + std::to_string(a.offsets_m.size()), slot.offset_index);
        if (slot.block_x >= a.block_columns() || slot.block_y >= a.block_rows())
            return differs("a block of " + std::to_string(a.block_columns()) + " x " + std::to_string(a.block_rows()),
                           std::max(slot.block_x, slot.block_y));
    }
    return std::nullopt;
}

/// Index from blocks of the auxiliary spheres to slots of the atlas. It takes eight bytes for each used slot and four
/// for each row of blocks. If two slots show the same block, the first one counts. Immutable once made; any number of
/// threads.
class PatchSlots {
public:
    /// The atlas must be valid (patch_atlas_problem). It need not outlive the constructor.
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

    /// The slot that shows the block, as an index in PatchAtlas::slots; -1 if there is none.
    int slot_of(int offset_index, int block_x, int block_y) const {
        const Block* found = first_from(offset_index, block_x, block_y);
        return found != nullptr && found->x == block_x ? found->slot : -1;
    }
    /// Whether a slot shows any block from `first_x` to `last_x`, inclusive, of row `block_y`.
    bool shows_any(int offset_index, int first_x, int last_x, int block_y) const {
        const Block* found = first_from(offset_index, first_x, block_y);
        return found != nullptr && found->x <= last_x;
    }

    struct AtlasPixel {
        int x, y;
    };

    /// The atlas pixel that shows pixel (x, y) of auxiliary sphere `offset_index`; nullopt if no slot does. The pixel
    /// is within the sphere's grid.
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
    /// The first block of a row at `block_x` or to its right; null if there is none.
    const Block* first_from(int offset_index, int block_x, int block_y) const {
        const std::size_t row = row_of(offset_index, block_y);
        const Block* const end = blocks_.data() + row_ends_[row + 1];
        const Block* const found = std::lower_bound(blocks_.data() + row_ends_[row], end, Block{block_x, 0});
        return found == end ? nullptr : found;
    }

    int block_rows_, side_, columns_;
    std::vector<std::uint32_t> row_ends_;  ///< where each row of each sphere ends in blocks_; element 0 is 0
    std::vector<Block> blocks_;
};

}  // namespace equistream
