#pragma once
/// An atlas with every kind of slot: used at random, some below one another, border blocks, unused ones.
#include <equistream/patches.h>

#include <random>

namespace equistream::testing {

inline PatchAtlas random_atlas(int columns, int rows, unsigned seed) {
    std::mt19937 random(seed);
    const auto below = [&](int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); };
    PatchAtlas atlas;
    atlas.sphere_width = 500;
    atlas.sphere_height = 243;
    for (int i = 0; i < 7; ++i)
        atlas.offsets_m.emplace_back(float(below(2000) - 1000) / 7e3f, float(below(2000) - 1000) / 7e3f,
                                     float(below(2000) - 1000) / 7e3f);
    atlas.columns = columns;
    atlas.rows = rows;
    atlas.slots.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    PatchAtlas::Slot last;
    for (PatchAtlas::Slot& slot : atlas.slots) {
        if (below(4) == 0)
            continue;
        slot = last;
        if (last.used && last.block_y + 1 < atlas.block_rows() && below(2) == 0)
            ++slot.block_y;
        else
            slot = {static_cast<std::uint8_t>(below(7)), static_cast<std::uint16_t>(below(atlas.block_columns())),
                    static_cast<std::uint16_t>(below(atlas.block_rows())), true};
        last = slot;
    }
    return atlas;
}

}  // namespace equistream::testing
