// Of pixels that are not the source's, steps along the column to the nearest that is, at most 255: fill_depth's first
// half.
layout(local_size_x = 256) in;

layout(binding = 1) uniform usampler2DArray eye_origin;
layout(binding = 0, r8ui) uniform writeonly uimage2DArray fill_steps;

#include "gap_tiles.glsl"

void main() {
    ivec3 at;
    ivec2 size = imageSize(fill_steps).xy;
    if (!listed_cell(1, TILE_SHIFT, at) || any(greaterThanEqual(at.xy, size)) ||
        texelFetch(eye_origin, at, 0).x == ORIGIN_SOURCE)
        return;
    int steps = 1;
    for (; steps < 255; ++steps) {
        int above = at.y - steps, below = at.y + steps;
        if ((above >= 0 && texelFetch(eye_origin, ivec3(at.x, above, at.z), 0).x == ORIGIN_SOURCE) ||
            (below < size.y && texelFetch(eye_origin, ivec3(at.x, below, at.z), 0).x == ORIGIN_SOURCE))
            break;
    }
    imageStore(fill_steps, at, uvec4(steps));
}
