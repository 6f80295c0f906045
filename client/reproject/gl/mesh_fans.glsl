// Cells larger than one of the lattice become two triangles, or, where smaller ones end on their border, a fan around
// their middle, so that no crack opens.
layout(local_size_x = 256) in;

#define BUILDS
#include "source_grid.glsl"
#include "mesh_lists.glsl"

bool is_corner(ivec2 p) {
    return imageLoad(cell_corners, corner_place(p)).x != 0u;
}

void main() {
    if (gl_GlobalInvocationID.x >= large_count)
        return;
    uint cell = large_cells[gl_GlobalInvocationID.x];
    ivec2 first = first_corner(cell);
    int side = 1 << int(cell >> 28), corners = 0, last = 0;
    for (int place = 0; place < 4 * side; ++place)
        corners += is_corner(first + on_border(place, side)) ? 1 : 0;
    if (corners == 4) {
        quads[appended(QUADS)] = cell;
        return;
    }
    for (int place = 1; place <= 4 * side; ++place)
        if (is_corner(first + on_border(place % (4 * side), side))) {
            fans[appended(FANS)] = uvec2(cell, uint(last) | uint(place % (4 * side)) << 16);
            last = place;
        }
}
