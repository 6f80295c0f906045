#include "patch_table.h"

#include "bits.h"

#include <equistream/error.h>

#include <bit>
#include <cstring>

namespace equistream {
namespace {

constexpr const char* place = "patches in the stream's frame data";
constexpr std::size_t head_bytes = 6;     // side, number of offsets, columns, rows
constexpr std::size_t offset_bytes = 12;  // three numbers in single precision

using Slot = PatchAtlas::Slot;

/// How many bits tell `count` things apart.
int bits_of(std::size_t count) {
    return static_cast<int>(std::bit_width(count - 1));
}

/// The patch that is cheapest to name: in vertical silhouettes one lies below the other.
Slot below(Slot slot) {
    ++slot.block_y;
    return slot;
}

void put_u16(std::vector<std::uint8_t>& bytes, int value) {
    bytes.push_back(static_cast<std::uint8_t>(value & 0xff));
    bytes.push_back(static_cast<std::uint8_t>(value >> 8));
}

}  // namespace

std::vector<std::uint8_t> pack_patch_table(const PatchAtlas& atlas) {
    if (const auto problem = patch_atlas_problem(atlas))
        throw InputError("patches: " + *problem);
    std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(atlas.block_side),
                                    static_cast<std::uint8_t>(atlas.offsets_m.size())};
    put_u16(bytes, atlas.columns);
    put_u16(bytes, atlas.rows);
    for (const glm::dvec3& offset : atlas.offsets_m) {
        const float numbers[3] = {float(offset.x), float(offset.y), float(offset.z)};
        const auto* raw = reinterpret_cast<const std::uint8_t*>(numbers);
        bytes.insert(bytes.end(), raw, raw + sizeof numbers);
    }
    BitWriter bits(bytes);
    Slot last;
    for (const Slot& slot : atlas.slots) {
        if (slot.used && last.used && slot == below(last)) {
            bits.put(1, 1);
        } else {
            bits.put(slot.used ? 2u : 0u, 2);
            if (slot.used) {
                bits.put(slot.offset_index, bits_of(atlas.offsets_m.size()));
                bits.put(slot.block_x, bits_of(static_cast<std::size_t>(atlas.block_columns())));
                bits.put(slot.block_y, bits_of(static_cast<std::size_t>(atlas.block_rows())));
            }
        }
        last = slot;
    }
    return bytes;
}

PatchAtlas unpack_patch_table(std::span<const std::uint8_t> bytes, const EquirectCamera& sphere) {
    const auto require = [&](std::size_t size) {
        if (bytes.size() < size)
            throw WorkError(
                expected_found(place, "at least " + std::to_string(size) + " bytes", std::to_string(bytes.size())));
    };
    require(head_bytes);
    PatchAtlas atlas;
    atlas.sphere_width = sphere.width;
    atlas.sphere_height = sphere.height;
    atlas.range = sphere.range;
    atlas.block_side = bytes[0];
    const std::size_t offset_count = bytes[1];
    atlas.columns = bytes[2] | bytes[3] << 8;
    atlas.rows = bytes[4] | bytes[5] << 8;
    if (offset_count > std::size_t{max_patch_offsets} || std::int64_t{atlas.columns} * atlas.rows > max_patch_slots)
        throw WorkError(expected_found(place,
                                       "at most " + std::to_string(max_patch_offsets) + " offsets and " +
                                           std::to_string(max_patch_slots) + " slots",
                                       std::to_string(offset_count) + " and " + std::to_string(atlas.columns) + " x " +
                                           std::to_string(atlas.rows)));
    require(head_bytes + offset_count * offset_bytes);
    for (std::size_t i = 0; i < offset_count; ++i) {
        float numbers[3];
        std::memcpy(numbers, bytes.data() + head_bytes + i * offset_bytes, sizeof numbers);
        atlas.offsets_m.emplace_back(numbers[0], numbers[1], numbers[2]);
    }
    atlas.slots.resize(static_cast<std::size_t>(atlas.columns) * static_cast<std::size_t>(atlas.rows));
    // Before slots are read, because the sphere's size decides how wide their fields are.
    if (const auto problem = patch_atlas_problem(atlas))
        throw WorkError(std::string(place) + ": " + *problem);
    BitReader bits(bytes.subspan(head_bytes + offset_count * offset_bytes), place);
    Slot last;
    for (Slot& slot : atlas.slots) {
        if (bits.get(1) == 1) {
            if (!last.used)
                throw WorkError(expected_found(place, "a used slot before one that lies below it", "an unused one"));
            slot = below(last);
        } else if (bits.get(1) == 1) {
            slot.used = true;
            slot.offset_index = static_cast<std::uint8_t>(bits.get(bits_of(offset_count)));
            slot.block_x =
                static_cast<std::uint16_t>(bits.get(bits_of(static_cast<std::size_t>(atlas.block_columns()))));
            slot.block_y = static_cast<std::uint16_t>(bits.get(bits_of(static_cast<std::size_t>(atlas.block_rows()))));
        }
        last = slot;
    }
    if (const auto problem = patch_atlas_problem(atlas))
        throw WorkError(std::string(place) + ": " + *problem);
    return atlas;
}

}  // namespace equistream
