// A draw of each block of a mesh (mesh_lists.glsl) for each eye that may see something of it.
layout(local_size_x = 64) in;

#include "source_grid.glsl"
#include "mesh_lists.glsl"

layout(std430, binding = 5) writeonly buffer MeshDraws {
    Draw draws[];
};

uniform int eye_count;

void main() {
    uint own = gl_GlobalInvocationID.x;
    if (own >= block_count())
        return;
    MeshBlock block = blocks[own];
    if (block.index_count == 0u)
        return;
    for (int eye = 0; eye < eye_count; ++eye)
        if ((block.seen >> eye & 1u) != 0u)
            draws[atomicAdd(draw_count, 1u)] = Draw(block.index_count, 1u, block.first_index, 0u, uint(eye));
}
