// Whether a tile holds a gap; one invocation each.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform usampler2DArray eye_origin;

#include "gap_tiles.glsl"

void main() {
    ivec3 tile = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(tile.xy, tile_grid)))
        return;
    // At the corner that four pixels share, a gather finds those and no others; beyond the edge it repeats the last.
    vec2 size = vec2(textureSize(eye_origin, 0).xy);
    bool has_gap = false;
    for (int y = 1; y < TILE_SIDE; y += 2)
        for (int x = 1; x < TILE_SIDE; x += 2) {
            vec2 corner = vec2(tile.xy * TILE_SIDE + ivec2(x, y)) / size;
            uvec4 origins = textureGather(eye_origin, vec3(corner, tile.z));
            has_gap = has_gap || COUNTS(origins.x) || COUNTS(origins.y) || COUNTS(origins.z) || COUNTS(origins.w);
        }
    tile_states[tile_number(tile)] = has_gap ? WITH_GAPS : NOT_THERE;
}
