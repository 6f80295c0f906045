// A level of the pyramid from the one below it.
#ifdef TILED
layout(local_size_x = 256) in;
#else
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;
#endif

#include "push_pull_levels.glsl"
#include "push_pull_pull.glsl"

layout(std430, binding = 2) writeonly buffer Layers {
    vec4 layers[];
};
layout(std430, binding = 3) readonly buffer FinerLayers {
    vec4 finer_layers[];
};
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
        int from = there ? cell_number(finer, child) : 0;
        children[k] = there ? finer_layers[from] : NO_LAYER;
        children[k + 4] = there ? finer_layers[from + 1] : NO_LAYER;
    }
    Halves halves = pulled(children, eyes[cell.z].agreement.y);
    int to = cell_number(level, cell);
    layers[to] = halves.far;
    layers[to + 1] = halves.near;
}
