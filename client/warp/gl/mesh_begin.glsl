// Nothing is listed or drawn yet, and of a mesh that is forgotten nothing is counted.
//
// Nothing but shaders writes this buffer. After glClearNamedBufferData of it nothing listed was built on an NVIDIA
// driver (580.159), as if it dispatched by those zeros still, barriers or not.
layout(local_size_x = 1) in;

#include "source_grid.glsl"
#include "mesh_lists.glsl"

uniform int forget_number;  // of the last time that the whole mesh was forgotten, counted from 1

void main() {
    if (forgotten != forget_number) {
        forgotten = forget_number;
        point_count = index_count = 0u;
    }
    draw_count = 0u;
    for (int list = 0; list < 2; ++list) {
        listed[list] = 0u;
        groups[3 * list] = 0u;
        groups[3 * list + 1] = groups[3 * list + 2] = 1u;
    }
}
