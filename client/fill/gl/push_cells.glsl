// Open layers of a level get colours of the level above.
#ifdef TILED
layout(local_size_x = 256) in;
#else
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;
#endif

#include "push_pull_levels.glsl"
#include "push_pull_push.glsl"

layout(std430, binding = 2) buffer Layers {
    vec4 layers[];
};
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
    int at = cell_number(level, cell);
    for (int half_of = 0; half_of < 2; ++half_of) {
        vec4 layer = layers[at + half_of];
        if (layer.w >= 0.0 && layer.r < 0.0)
            layers[at + half_of].rgb = pushed(cell, layer.w);
    }
}
