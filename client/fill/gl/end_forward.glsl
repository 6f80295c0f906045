// Takes what was drawn forward into the gaps over into the eyes' depths; nothing is drawn then.
layout(local_size_x = 256) in;

layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 1, r32f) uniform writeonly image2DArray eye_inverse_planar;

#include "gap_tiles.glsl"
#include "forward_keys.glsl"

void main() {
    ivec3 at;
    if (!listed_cell(1, TILE_SHIFT, at) || any(greaterThanEqual(at.xy, imageSize(eye_inverse_planar).xy)) ||
        texelFetch(eye_origin, at, 0).x != ORIGIN_GAP)
        return;
    imageStore(eye_inverse_planar, at, vec4(inverse_of_key(imageLoad(forward_keys, at).x)));
    imageStore(forward_keys, at, ivec4(NO_KEY));
}
