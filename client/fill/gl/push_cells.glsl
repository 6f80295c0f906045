// Open layers of a level get colours of the level above.
#include "push_pull_cells.glsl"
#include "push_pull_push.glsl"

layout(binding = 4) uniform sampler2DArray pulled_layers;
layout(binding = 0, rgba32f) uniform writeonly image2DArray layers;  // the same

void main() {
    ivec3 cell;
    if (!cell_of_level(1, cell))
        return;
    ivec2 beside = 2 * (cell.xy & 1) - 1;
    vec4 around[8];
    for (int k = 0; k < 8; ++k)
        around[k] = coarser_layer(ivec3((cell.xy >> 1) + beside * ivec2(k >> 1 & 1, k >> 2), cell.z), k & 1);
    for (int half_of = 0; half_of < 2; ++half_of) {
        vec4 layer = texelFetch(pulled_layers, layer_at(cell, half_of), 0);
        if (layer.w >= 0.0 && layer.r < 0.0)
            imageStore(layers, layer_at(cell, half_of),
                       vec4(pushed(around, layer.w, eyes[cell.z].agreement.y), layer.w));
    }
}
