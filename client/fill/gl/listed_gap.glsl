// The gap pixel that an invocation has, of the tiles with gaps. Needs a texture `eye_origin` and an image `eye_colour`.
#include "gap_tiles.glsl"

bool listed_gap(out ivec3 at) {
    return listed_cell(1, TILE_SHIFT, at) && all(lessThan(at.xy, imageSize(eye_colour).xy)) &&
           texelFetch(eye_origin, at, 0).x == ORIGIN_GAP;
}
