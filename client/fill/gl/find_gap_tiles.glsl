// Whether a tile holds a gap; one invocation each.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform usampler2DArray eye_origin;

#include "gap_tiles.glsl"

void main() {
    ivec3 tile = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(tile.xy, tile_grid)))
        return;
    ivec2 first = tile.xy * TILE_SIDE, end = min(first + TILE_SIDE, textureSize(eye_origin, 0).xy);
    bool has_gap = false;
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x)
            has_gap = has_gap || COUNTS(texelFetch(eye_origin, ivec3(x, y, tile.z), 0).x);
    tile_states[tile_number(tile)] = has_gap ? WITH_GAPS : NOT_THERE;
}
