// Whether a tile is so close to one with gaps that its samples are asked for light.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0, r8ui) uniform writeonly uimage2DArray wanted_tiles;

#include "gap_tiles.glsl"

void main() {
    ivec3 tile = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(tile.xy, tile_grid)))
        return;
    bool wanted = false;
    for (int y = -LIT_TILES_AROUND; y <= LIT_TILES_AROUND; ++y)
        for (int x = -LIT_TILES_AROUND; x <= LIT_TILES_AROUND; ++x)
            wanted = wanted || tile_state(tile + ivec3(x, y, 0)) == WITH_GAPS;
    imageStore(wanted_tiles, tile, uvec4(wanted));
}
