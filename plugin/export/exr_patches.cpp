#include "exr_patches.h"

#include <equistream/formatted.h>

#include <string_view>

namespace equistream {
namespace {

constexpr const char* sphere_size = "equistream:sphereSize";
constexpr const char* patch_side = "equistream:patchSide";
constexpr const char* patch_offsets = "equistream:patchOffsets";
constexpr const char* patch_slots = "equistream:patchSlots";

/// Numbers and the signs between them, from the front.
class Words {
public:
    Words(const AttributeReader& in, const char* name, const char* expected)
        : in_(in), name_(name), expected_(expected), text_(in.text(name)), left_(text_) {}

    bool at_end() const { return left_.empty(); }
    bool take(char sign) {
        const bool there = !left_.empty() && left_.front() == sign;
        if (there)
            left_.remove_prefix(1);
        return there;
    }
    void require(char sign) {
        if (!take(sign))
            refuse();
    }
    template <typename T>
    T number() {
        T value = 0;
        const auto [end, error] = std::from_chars(left_.data(), left_.data() + left_.size(), value);
        if (error != std::errc())
            refuse();
        left_.remove_prefix(static_cast<std::size_t>(end - left_.data()));
        return value;
    }
    [[noreturn]] void refuse() const { in_.refuse(name_, expected_, "\"" + std::string(left_.substr(0, 40)) + "\""); }

private:
    const AttributeReader& in_;
    const char* name_;
    const char* expected_;
    std::string text_;
    std::string_view left_;
};

void read_offsets(const AttributeReader& in, PatchAtlas& atlas) {
    Words words(in, patch_offsets, "offsets \"x y z\" in metres, at most 64, between commas");
    do {
        glm::dvec3 offset;
        offset.x = words.number<double>();
        words.require(' ');
        offset.y = words.number<double>();
        words.require(' ');
        offset.z = words.number<double>();
        if (atlas.offsets_m.size() == static_cast<std::size_t>(max_patch_offsets))
            words.refuse();
        atlas.offsets_m.push_back(offset);
    } while (words.take(','));
    if (!words.at_end())
        words.refuse();
}

void read_slots(const AttributeReader& in, PatchAtlas& atlas) {
    Words words(in, patch_slots, "a slot \"-\" or \"offset:column:row\" for each patch of the picture, between commas");
    for (std::size_t i = 0; i < atlas.slots.size(); ++i) {
        if (i > 0)
            words.require(',');
        if (words.take('-'))
            continue;
        PatchAtlas::Slot& slot = atlas.slots[i];
        slot.used = true;
        slot.offset_index = words.number<std::uint8_t>();
        words.require(':');
        slot.block_x = words.number<std::uint16_t>();
        words.require(':');
        slot.block_y = words.number<std::uint16_t>();
    }
    if (!words.at_end())
        words.refuse();
}

}  // namespace

void write_patches(AttributeWriter& out, const PatchAtlas& atlas) {
    if (const auto problem = patch_atlas_problem(atlas))
        throw InputError("patches: " + *problem);
    out.text(sphere_size, size_text(atlas.sphere_width, atlas.sphere_height));
    out.integer(patch_side, atlas.block_side);
    std::string text;
    for (const glm::dvec3& o : atlas.offsets_m)
        text += (text.empty() ? "" : ",") + formatted("%.17g %.17g %.17g", o.x, o.y, o.z);
    out.text(patch_offsets, text);
    text.clear();
    for (const PatchAtlas::Slot& slot : atlas.slots) {
        text += text.empty() ? "" : ",";
        text += slot.used ? formatted("%d:%d:%d", slot.offset_index, slot.block_x, slot.block_y) : "-";
    }
    out.text(patch_slots, text);
}

bool has_patches(const AttributeReader& in) {
    return in.has(patch_side);
}

PatchAtlas read_patches(const AttributeReader& in, int width, int height) {
    PatchAtlas atlas;
    atlas.block_side = in.integer(patch_side);
    if (atlas.block_side < min_patch_side || atlas.block_side > max_patch_side || width % atlas.block_side != 0 ||
        height % atlas.block_side != 0)
        in.refuse(patch_side, "a side of 4 to 64 pixels that divides the picture's " + size_text(width, height),
                  std::to_string(atlas.block_side));
    atlas.columns = width / atlas.block_side;
    atlas.rows = height / atlas.block_side;
    Words size(in, sphere_size, "a size such as 1920x960");
    atlas.sphere_width = size.number<int>();
    size.require('x');
    atlas.sphere_height = size.number<int>();
    read_offsets(in, atlas);
    if (atlas.columns > max_patch_slots / atlas.rows)
        in.refuse(patch_slots, "at most " + std::to_string(max_patch_slots) + " slots",
                  size_text(atlas.columns, atlas.rows));
    atlas.slots.resize(static_cast<std::size_t>(atlas.columns) * static_cast<std::size_t>(atlas.rows));
    read_slots(in, atlas);
    if (const auto problem = patch_atlas_problem(atlas))
        throw InputError(in.file() + ": patches: " + *problem);
    return atlas;
}

}  // namespace equistream
