// What a mesh is drawn of: for each block of a source's lattice (source_lattice.glsl) points and triangles, found once a
// frame (mesh_cells.glsl, then mesh_points.glsl), and draws of those that eyes see (mesh_cull.glsl).

struct MeshBlock {
    vec4 cone;      // of all directions: its axis and the cosine of its radius
    vec2 inverses;  // least and largest 1 / distance
    uint first_index, index_count;
};

struct Draw {
    uint index_count, instances, first_index, base_vertex, eye;
};

layout(std430, binding = 0) buffer MeshCounts {
    uint point_count, index_count;  // that there would be if there were room
    uint draw_count;
};
layout(std430, binding = 1) buffer MeshBlocks {
    MeshBlock blocks[];
};
#ifdef BUILDS
layout(std430, binding = 2) writeonly buffer MeshPoints {
    vec4 points[];  // (q, k)
};
layout(std430, binding = 3) writeonly buffer MeshIndices {
    uint indices[];
};

const int SIDE = 1 << MESH_LEVELS, POINTS = SIDE + 1;  // of a block, in cells and in points

// Where no cell begins, 0; else 1 + log2 of its side, or of one whose corners are not all joined CUT, and in the upper
// four bits whether corner i is joined to the next.
layout(binding = 0, r8ui) uniform uimage2D mesh_cells;
layout(binding = 1, r8ui) uniform uimage2D mesh_corners;  // 1: a point of the lattice is a corner of some cell
const uint CUT = 7u;

/// Of the block of a work group.
ivec2 block_origin() {
    return ivec2(source_closes != 0 ? 0 : -1, -1) + ivec2(gl_WorkGroupID.xy) * SIDE;
}
ivec2 cells_in_block() {
    return min(ivec2(SIDE), source_size - block_origin());
}

/// Of a point within a cell's closed border.
ivec2 corner_place(ivec2 p) {
    return ivec2(source_closes == 0 ? p.x + 1 : p.x >= source_size.x ? p.x - source_size.x : p.x, p.y + 1);
}
#endif
