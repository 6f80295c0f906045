// The tiles that a picture is to be made anew in.
layout(local_size_x = 64) in;

#include "source_grid.glsl"
#include "extrapolate_tiles.glsl"

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (tile >= tile_count() || tiles[tile] == 0u)
        return;
    tiles[tile] = (tiles[tile] & MOVES) | ((tiles[tile] & REACHED) != 0u ? WAS_REACHED : 0u);
    uint i = atomicAdd(listed, 1u);
    tiles[tile_count() + i] = tile;
    atomicMax(groups[0], min(i + 1u, MAX_GROUPS_IN_ROW));
    atomicMax(groups[1], i / MAX_GROUPS_IN_ROW + 1u);
}
