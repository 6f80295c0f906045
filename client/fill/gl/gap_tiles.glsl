// Squares of pixels in or next to which there are gaps, as GapTiles has them: numbered row by row, eye by eye.

const int TILE_SIDE = 1 << TILE_SHIFT;
const uint MAX_GROUPS = 65535u;  // along an axis that every driver has; more go along the next one
const uint NOT_THERE = 0u, BESIDE_GAPS = 1u, WITH_GAPS = 2u;

layout(std430, binding = 0) buffer TileStates {
    uint tile_states[];
};
layout(std430, binding = 1) buffer TileLists {
    // Of 256 invocations that have all cells of a list's tiles, at each of the levels at which a tile has any.
    uvec4 groups[2 * (TILE_SHIFT + 1)];
    uint tile_counts[2];  // of those that are there, and of those with gaps
    ivec2 tile_grid;      // columns and rows of one eye
    uint tile_lists[];    // the one after the other, as long as there are tiles: column, row and eye in 15, 15, 2 bits
};

int tile_number(ivec3 tile) {
    return (tile.z * tile_grid.y + tile.y) * tile_grid.x + tile.x;
}

uint tile_state(ivec3 tile) {
    bool inside = all(greaterThanEqual(tile.xy, ivec2(0))) && all(lessThan(tile.xy, tile_grid));
    return inside ? tile_states[tile_number(tile)] : NOT_THERE;
}

/// The cell that an invocation has, of a level at which tiles are 1 << shift cells wide, in tiles of a list; false for
/// those left over.
bool listed_cell(int list, int shift, out ivec3 cell) {
    uint index = (gl_WorkGroupID.y * MAX_GROUPS + gl_WorkGroupID.x) * 256u + gl_LocalInvocationID.x, entry = index >> (2 * shift);
    if (entry >= tile_counts[list])
        return false;
    uint listed = tile_lists[list * (tile_lists.length() / 2) + int(entry)];
    int mask = (1 << shift) - 1, in_tile = int(index) & ((1 << (2 * shift)) - 1);
    ivec3 tile = ivec3(listed & 0x7fffu, listed >> 15 & 0x7fffu, listed >> 30);
    cell = ivec3((tile.xy << shift) + ivec2(in_tile & mask, in_tile >> shift), tile.z);
    return true;
}
