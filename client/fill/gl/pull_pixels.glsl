// Level 1 of the pyramid, of the pixels.
layout(local_size_x = 256) in;

layout(binding = 0) uniform sampler2DArray eye_colour;
layout(binding = 1) uniform usampler2DArray eye_origin;

#include "push_pull_levels.glsl"
#include "push_pull_pull.glsl"
#include "push_pull_depth.glsl"

layout(binding = 0, rgba32f) uniform writeonly image2DArray layers;
uniform ivec3 level;

void main() {
    ivec3 cell;
    if (!listed_cell(0, level.z, cell))
        return;
    ivec2 size = textureSize(eye_origin, 0).xy;
    vec4 children[8];
    for (int k = 0; k < 4; ++k) {
        ivec3 at = ivec3(2 * cell.xy + ivec2(k & 1, k >> 1), cell.z);
        children[k + 4] = NO_LAYER;
        if (any(greaterThanEqual(at.xy, size))) {
            children[k] = NO_LAYER;
            continue;
        }
        bool is_gap = texelFetch(eye_origin, at, 0).x == ORIGIN_GAP;
        children[k] = vec4(is_gap ? OPEN : texelFetch(eye_colour, at, 0).rgb, w_at(at));
    }
    Halves halves = pulled(children, eyes[cell.z].agreement.y);
    imageStore(layers, layer_at(cell, 0), halves.far);
    imageStore(layers, layer_at(cell, 1), halves.near);
}
