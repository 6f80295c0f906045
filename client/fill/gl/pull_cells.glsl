// A level of the pyramid from the one below it.
#include "push_pull_cells.glsl"
#include "push_pull_pull.glsl"

layout(binding = 0, rgba32f) uniform writeonly image2DArray layers;
layout(binding = 3) uniform sampler2DArray finer_layers;
uniform ivec3 finer;

void main() {
    ivec3 cell;
    if (!cell_of_level(0, cell))
        return;
    vec4 children[8];
    for (int k = 0; k < 4; ++k) {
        ivec3 child = ivec3(2 * cell.xy + ivec2(k & 1, k >> 1), cell.z);
#ifdef TILED
        const bool there = true;  // in the same tile
#else
        bool there = is_there(finer, child);
#endif
        children[k] = there ? texelFetch(finer_layers, layer_at(child, 0), 0) : NO_LAYER;
        children[k + 4] = there ? texelFetch(finer_layers, layer_at(child, 1), 0) : NO_LAYER;
    }
    Halves halves = pulled(children, eyes[cell.z].agreement.y);
    imageStore(layers, layer_at(cell, 0), halves.far);
    imageStore(layers, layer_at(cell, 1), halves.near);
}
