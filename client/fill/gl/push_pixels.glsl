// Gap pixels get colours of level 1, the four of a cell together: they share the cells around.
layout(local_size_x = 256) in;

layout(binding = 1) uniform usampler2DArray eye_origin;
layout(binding = 0, rgba8) uniform writeonly image2DArray eye_colour;
layout(binding = 1, r8ui) uniform writeonly uimage2DArray filled_origin;  // the same as eye_origin

#include "push_pull_levels.glsl"
#include "push_pull_push.glsl"
#include "push_pull_depth.glsl"
#include "in_levels.glsl"

void main() {
    ivec3 cell;
    if (!listed_cell(1, coarser.z, cell))
        return;
    ivec2 size = textureSize(eye_origin, 0).xy;
    float tolerance = eyes[cell.z].agreement.y;
    vec4 around[18];  // three by three cells
    for (int k = 0; k < 18; ++k)
        around[k] = coarser_layer(cell + ivec3((k >> 1) % 3 - 1, (k >> 1) / 3 - 1, 0), k & 1);
    for (int pixel = 0; pixel < 4; ++pixel) {
        ivec2 in_cell = ivec2(pixel & 1, pixel >> 1), beside = 2 * in_cell - 1;
        ivec3 at = ivec3(2 * cell.xy + in_cell, cell.z);
        bool is_gap = all(lessThan(at.xy, size)) && texelFetch(eye_origin, at, 0).x == ORIGIN_GAP;
        vec4 layers[8];
        for (int k = 0; k < 8; ++k)
            layers[k] = around[8 + 2 * (beside.x * (k >> 1 & 1) + 3 * beside.y * (k >> 2)) + (k & 1)];
        vec3 colour = pushed(layers, w_at(at), tolerance);
        if (is_gap && colour.r >= 0.0) {
            imageStore(eye_colour, at, vec4(in_levels(colour), 1.0));
            imageStore(filled_origin, at, uvec4(ORIGIN_PUSH_PULL));
        }
    }
}
