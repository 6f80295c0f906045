// Gap pixels get colours of level 1.
layout(local_size_x = 256) in;

layout(binding = 1) uniform usampler2DArray eye_origin;
layout(binding = 0, rgba8) uniform writeonly image2DArray eye_colour;
layout(binding = 1, r8ui) uniform writeonly uimage2DArray filled_origin;  // the same as eye_origin

#include "push_pull_levels.glsl"
#include "push_pull_push.glsl"
#include "push_pull_depth.glsl"

void main() {
    ivec3 at;
    if (!listed_cell(1, TILE_SHIFT, at) || any(greaterThanEqual(at.xy, textureSize(eye_origin, 0).xy)) ||
        texelFetch(eye_origin, at, 0).x != ORIGIN_GAP)
        return;
    vec3 colour = pushed(at, w_at(at));
    if (colour.r < 0.0)
        return;
    imageStore(eye_colour, at, vec4(colour, 1.0));
    imageStore(filled_origin, at, uvec4(ORIGIN_PUSH_PULL));
}
