// How many groups a pass over samples has that draws into gaps: none, where there are none.
layout(local_size_x = 1) in;

#include "gap_tiles.glsl"

layout(std430, binding = 2) writeonly buffer Groups {
    uint pass_groups[3];
};
uniform ivec3 groups_with_gaps;

void main() {
    bool has_gaps = tile_counts[1] != 0u;
    for (int axis = 0; axis < 3; ++axis)
        pass_groups[axis] = has_gaps ? uint(groups_with_gaps[axis]) : 0u;
}
