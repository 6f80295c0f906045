// What a mesh is drawn of: lists of cells of a source's lattice (mesh_lattice.glsl), each with the draw that goes
// through it. Cells are their first corner's column and row, from -1 on, in 14 bits each, and four bits more.

const uint QUADS = 0u, FANS = 1u, CUTS = 2u;
const uint VERTICES[3] = uint[3](6u, 3u, 24u);  // of an entry

struct Draw {
    uint vertices, instances, first_vertex, first_instance;
};

layout(std430, binding = 0) buffer MeshLists {
    Draw draws[3];
    uint large_groups[3];  // of 256 invocations, one for each of large_cells
    uint large_count;
};
layout(std430, binding = 1) buffer MeshQuads {
    uint quads[];  // whole cells of two triangles; the bits: log2 of their side
};
layout(std430, binding = 2) buffer MeshFans {
    uvec2 fans[];  // triangles of cells that meet smaller ones: the cell as in quads, two places on its border
};
layout(std430, binding = 3) buffer MeshCuts {
    uint cuts[];  // cells whose corners are not all joined; the bits: whether corner i is joined to the next
};
#ifdef BUILDS
layout(std430, binding = 4) buffer MeshLargeCells {
    uint large_cells[];  // whole ones larger than 1, as in quads
};
#endif

uint packed_cell(ivec2 first, uint bits) {
    uvec2 from_0 = uvec2(first + 1);
    return from_0.x | from_0.y << 14 | bits << 28;
}

ivec2 first_corner(uint cell) {
    return ivec2(cell & 0x3fffu, cell >> 14 & 0x3fffu) - 1;
}

/// Of a cell of some side, clockwise from its first corner.
ivec2 on_border(int place, int side) {
    int edge = place / side, along = place % side;
    return edge == 0 ? ivec2(along, 0) : edge == 1 ? ivec2(side, along) : edge == 2 ? ivec2(side - along, side)
                                                                                  : ivec2(0, side - along);
}

#ifdef BUILDS
uint appended(uint list) {
    return atomicAdd(draws[list].vertices, VERTICES[list]) / VERTICES[list];
}

layout(binding = 0, r8ui) uniform uimage2D cell_corners;  // 1: a point of the lattice is a corner of some cell

/// Of a point within a cell's closed border.
ivec2 corner_place(ivec2 p) {
    return ivec2(source_closes != 0 ? p.x % source_size.x : p.x + 1, p.y + 1);
}
#endif
