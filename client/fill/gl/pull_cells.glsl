// A level of the pyramid from the one below it.
#ifdef TILED
layout(local_size_x = 256) in;
#else
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;
#endif

#include "push_pull_levels.glsl"
#include "push_pull_pull.glsl"

layout(binding = 0, rgba32f) uniform writeonly image2DArray layers;
layout(binding = 3) uniform sampler2DArray finer_layers;
uniform ivec3 level;
uniform ivec3 finer;

void main() {
#ifdef TILED
    ivec3 cell;
    if (!listed_cell(0, level.z, cell))
        return;
#else
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell.xy, level.xy)))
        return;
#endif
    vec4 children[8];
    for (int k = 0; k < 4; ++k) {
        ivec3 child = ivec3(2 * cell.xy + ivec2(k & 1, k >> 1), cell.z);
        bool there = is_there(finer, child);
        children[k] = there ? texelFetch(finer_layers, layer_at(child, 0), 0) : NO_LAYER;
        children[k + 4] = there ? texelFetch(finer_layers, layer_at(child, 1), 0) : NO_LAYER;
    }
    Halves halves = pulled(children, eyes[cell.z].agreement.y);
    imageStore(layers, layer_at(cell, 0), halves.far);
    imageStore(layers, layer_at(cell, 1), halves.near);
}
