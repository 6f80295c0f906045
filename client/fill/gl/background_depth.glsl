// How far away the background of a gap is, where nobody knows what its pixels see.
layout(local_size_x = 256) in;

layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 0, r32f) uniform image2DArray eye_inverse_planar;

#include "gap_tiles.glsl"

#define INVERSE_PLANAR(at) imageLoad(eye_inverse_planar, at).x
#include "background.glsl"

void main() {
    ivec3 at;
    ivec2 size = imageSize(eye_inverse_planar).xy;
    if (listed_cell(1, TILE_SHIFT, at) && all(lessThan(at.xy, size)) && texelFetch(eye_origin, at, 0).x == ORIGIN_GAP)
        imageStore(eye_inverse_planar, at, vec4(background_inverse(at, size)));
}
