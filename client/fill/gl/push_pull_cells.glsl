// Which cell of a level an invocation is for: of listed tiles, or (without TILED) of a level that has all.
#ifdef TILED
layout(local_size_x = 256) in;
#else
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;
#endif

#include "push_pull_levels.glsl"

uniform ivec3 level;

/// False where there is none. `list` is listed_cell's.
bool cell_of_level(int list, out ivec3 cell) {
#ifdef TILED
    return listed_cell(list, level.z, cell);
#else
    cell = ivec3(gl_GlobalInvocationID);
    return all(lessThan(cell.xy, level.xy));
#endif
}
