// Which pixels in and beside tiles with gaps are filled; of gaps, a list for each eye.
layout(local_size_x = 256) in;

layout(binding = 3) uniform usampler2DArray eye_origin;

#include "gap_tiles.glsl"
#include "spread_lists.glsl"

void main() {
    ivec3 at;
    ivec2 size = textureSize(eye_origin, 0).xy;
    if (!listed_cell(0, TILE_SHIFT, at) || any(greaterThanEqual(at.xy, size)))
        return;
    uint pixels = uint(size.x * size.y), eye = uint(at.z), pixel = uint(at.y * size.x + at.x);
    bool is_gap = texelFetch(eye_origin, at, 0).x == ORIGIN_GAP;
    states[eye * pixels + pixel] = is_gap ? OPEN : 0u;
    if (is_gap)
        entries[2u * eye * pixels + atomicAdd(candidate_counts[eye], 1u)] = pixel;
}
