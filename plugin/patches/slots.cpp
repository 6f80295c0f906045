#include "slots.h"

#include <tuple>

namespace equistream {

using Slot = PatchAtlas::Slot;

std::size_t assign_slots(std::vector<Slot> chosen, PatchAtlas& atlas) {
    // Column by column, so that patches below one another follow each other: that is cheap to send.
    const auto key = [](const Slot& s) { return std::tuple(s.offset_index, s.block_x, s.block_y); };
    const auto before = [&](const Slot& a, const Slot& b) { return key(a) < key(b); };
    std::sort(chosen.begin(), chosen.end(), before);
    constexpr std::size_t nowhere = static_cast<std::size_t>(-1);
    std::vector<std::size_t> slot_of(chosen.size(), nowhere);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < atlas.slots.size(); ++i) {
        Slot& slot = atlas.slots[i];
        if (!slot.used)
            continue;
        const auto found = std::lower_bound(chosen.begin(), chosen.end(), slot, before);
        if (found != chosen.end() && *found == slot) {
            slot_of[static_cast<std::size_t>(found - chosen.begin())] = i;
            ++kept;
        } else {
            slot = {};
        }
    }
    const auto is_free = [&](std::size_t slot) { return slot < atlas.slots.size() && !atlas.slots[slot].used; };
    std::size_t free = 0;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        if (slot_of[i] != nowhere)
            continue;
        while (!is_free(free))
            ++free;
        Slot below;
        if (i > 0) {
            below = chosen[i - 1];
            ++below.block_y;
        }
        slot_of[i] = below == chosen[i] && is_free(slot_of[i - 1] + 1) ? slot_of[i - 1] + 1 : free;
        atlas.slots[slot_of[i]] = chosen[i];
    }
    return kept;
}

}  // namespace equistream
