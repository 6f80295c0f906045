#include "slots.h"

#include <tuple>

namespace equistream {

using Slot = PatchAtlas::Slot;

std::size_t assign_slots(std::vector<Slot> chosen, PatchAtlas& atlas) {
    // Column by column, so that patches below one another follow each other: that is cheap to send.
    const auto key = [](const Slot& s) { return std::tuple(s.offset_index, s.block_x, s.block_y); };
    const auto before = [&](const Slot& a, const Slot& b) { return key(a) < key(b); };
    std::sort(chosen.begin(), chosen.end(), before);
    std::vector<bool> placed(chosen.size(), false);
    std::size_t kept = 0;
    for (Slot& slot : atlas.slots) {
        if (!slot.used)
            continue;
        const auto found = std::lower_bound(chosen.begin(), chosen.end(), slot, before);
        if (found != chosen.end() && *found == slot) {
            placed[static_cast<std::size_t>(found - chosen.begin())] = true;
            ++kept;
        } else {
            slot = {};
        }
    }
    auto free = atlas.slots.begin();
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        if (placed[i])
            continue;
        free = std::find_if(free, atlas.slots.end(), [](const Slot& s) { return !s.used; });
        *free = chosen[i];
    }
    return kept;
}

}  // namespace equistream
