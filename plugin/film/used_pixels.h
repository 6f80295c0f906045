#pragma once
/// Which pixels of an atlas's tiles lie in slots that somebody uses. Any number of threads.
#include <equistream/equistream.h>
#include <equistream/patches.h>

#include <mutex>
#include <unordered_map>
#include <vector>

namespace equistream {

class UsedPixels {
public:
    /// Within the tile, row by row, ascending; the list stays where it is. Ask for one atlas only.
    const std::vector<std::uint32_t>& of(const es_tile& tile, const PatchAtlas& atlas) const {
        const std::lock_guard lock(mutex_);
        const auto [known, is_new] = by_tile_.try_emplace(tile.id);
        if (is_new)
            for (std::uint32_t i = 0; i < tile.pixel_count; ++i) {
                const auto pixel = static_cast<int>(i);
                if (atlas.slot_at(tile.x + pixel % tile.width, tile.y + pixel / tile.width).used)
                    known->second.push_back(i);
            }
        return known->second;
    }

private:
    mutable std::mutex mutex_;
    mutable std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> by_tile_;
};

}  // namespace equistream
