// Steps along the row or column from pixels that are not the source's to the nearest that is, at most 255. Two passes
// over the tiles that have any: along columns; then, ACROSS, along rows to the steps of columns.
layout(local_size_x = 256) in;

layout(binding = 1) uniform usampler2DArray eye_origin;
#ifdef ACROSS
layout(binding = 5) uniform usampler2DArray column_steps;
#endif
layout(binding = 0, r8ui) uniform writeonly uimage2DArray steps;

#include "gap_tiles.glsl"

bool is_source(ivec3 at) {
    return texelFetch(eye_origin, at, 0).x == ORIGIN_SOURCE;
}

#ifdef ACROSS
int nearest(ivec3 at, ivec2 size) {
    int best = int(texelFetch(column_steps, at, 0).x);
    for (int i = 1; i < best; ++i)
        for (int k = -1; k <= 1; k += 2) {
            ivec3 there = at + ivec3(k * i, 0, 0);
            if (there.x >= 0 && there.x < size.x)
                best = min(best, i + (is_source(there) ? 0 : int(texelFetch(column_steps, there, 0).x)));
        }
    return best;
}
#else
int nearest(ivec3 at, ivec2 size) {
    int i = 1;
    for (; i < 255; ++i) {
        ivec3 above = at - ivec3(0, i, 0), below = at + ivec3(0, i, 0);
        if ((above.y >= 0 && is_source(above)) || (below.y < size.y && is_source(below)))
            break;
    }
    return i;
}
#endif

void main() {
    ivec3 at;
    ivec2 size = imageSize(steps).xy;
    if (listed_cell(1, TILE_SHIFT, at) && all(lessThan(at.xy, size)) && !is_source(at))
        imageStore(steps, at, uvec4(nearest(at, size)));
}
