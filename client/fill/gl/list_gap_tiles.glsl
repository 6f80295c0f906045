// Tiles beside those with gaps, and the lists of both.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

#include "gap_tiles.glsl"

void append(int list, ivec3 tile) {
    uint before = atomicAdd(tile_counts[list], 1u);
    tile_lists[list * (tile_lists.length() / 2) + int(before)] = uint(tile.x) | uint(tile.y) << 15 | uint(tile.z) << 30;
    for (int shift = 0; shift <= TILE_SHIFT; ++shift) {
        if ((before & ((256u >> (2 * shift)) - 1u)) != 0u)
            continue;  // not the first of its group
        uint group = before >> (8 - 2 * shift);
        atomicMax(groups[list * (TILE_SHIFT + 1) + shift].x, min(group + 1u, MAX_GROUPS));
        atomicMax(groups[list * (TILE_SHIFT + 1) + shift].y, group / MAX_GROUPS + 1u);
    }
}

void main() {
    ivec3 tile = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(tile.xy, tile_grid)))
        return;
    bool has_gap = tile_state(tile) == WITH_GAPS, beside = false;
    for (int k = 0; k < 9; ++k)
        beside = beside || tile_state(tile + ivec3(k % 3 - 1, k / 3 - 1, 0)) == WITH_GAPS;
    if (beside)
        append(0, tile);
    if (has_gap)
        append(1, tile);
    else if (beside)
        tile_states[tile_number(tile)] = BESIDE_GAPS;
}
