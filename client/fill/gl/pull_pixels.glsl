// Level 1 of the pyramid, of the pixels.
layout(local_size_x = 256) in;

layout(binding = 0) uniform sampler2DArray eye_colour;
layout(binding = 1) uniform usampler2DArray eye_origin;

#include "push_pull_levels.glsl"
#include "push_pull_pull.glsl"
#include "push_pull_depth.glsl"

layout(binding = 0, rgba32f) uniform writeonly image2DArray layers;
uniform ivec3 level;

const int GATHERED[4] = int[4](3, 2, 0, 1);  // where a gather has the pixels, row by row

void main() {
    ivec3 cell;
    if (!listed_cell(0, level.z, cell))
        return;
    ivec2 size = textureSize(eye_origin, 0).xy;
    // At the corner that four pixels share, a gather finds those and no others.
    vec3 corner = vec3(vec2(2 * cell.xy + 1) / vec2(size), cell.z);
    vec3 corner_of_depth = vec3(vec2(2 * cell.xy + 1) / vec2(textureSize(eye_depth, 0).xy), cell.z);
    uvec4 origins = textureGather(eye_origin, corner);
    vec4 reds = textureGather(eye_colour, corner, 0), greens = textureGather(eye_colour, corner, 1);
    vec4 blues = textureGather(eye_colour, corner, 2), depths = textureGather(eye_depth, corner_of_depth);
    vec4 children[8];
    for (int k = 0; k < 4; ++k) {
        ivec3 at = ivec3(2 * cell.xy + ivec2(k & 1, k >> 1), cell.z);
        int from = GATHERED[k];
        vec3 colour = origins[from] == ORIGIN_GAP ? OPEN : vec3(reds[from], greens[from], blues[from]);
        children[k] = all(lessThan(at.xy, size)) ? vec4(colour, w_of(depths[from], at)) : NO_LAYER;
        children[k + 4] = NO_LAYER;
    }
    Halves halves = pulled(children, eyes[cell.z].agreement.y);
    imageStore(layers, layer_at(cell, 0), halves.far);
    imageStore(layers, layer_at(cell, 1), halves.near);
}
