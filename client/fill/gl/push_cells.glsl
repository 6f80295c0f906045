// Open layers of a level get colours of the level above.
#ifdef TILED
layout(local_size_x = 256) in;
#else
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;
#endif

#include "push_pull_levels.glsl"
#include "push_pull_push.glsl"

layout(binding = 4) uniform sampler2DArray pulled_layers;
layout(binding = 0, rgba32f) uniform writeonly image2DArray layers;  // the same
uniform ivec3 level;

void main() {
#ifdef TILED
    ivec3 cell;
    if (!listed_cell(1, level.z, cell))
        return;
#else
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell.xy, level.xy)))
        return;
#endif
    for (int half_of = 0; half_of < 2; ++half_of) {
        vec4 layer = texelFetch(pulled_layers, layer_at(cell, half_of), 0);
        if (layer.w >= 0.0 && layer.r < 0.0)
            imageStore(layers, layer_at(cell, half_of), vec4(pushed(cell, layer.w), layer.w));
    }
}
