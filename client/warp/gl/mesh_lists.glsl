// What a mesh is drawn of: for each block of a source's lattice (source_block.glsl) points and triangles, and draws of
// those that eyes see. What no eye has seen yet is not there, and what shows other samples by now is built anew where
// an eye sees it: mesh_wanted.glsl lists such blocks for mesh_cells.glsl, then mesh_points.glsl; mesh_draws.glsl ends it.
#define SOURCE_BLOCKS_BINDING 1
#include "source_block.glsl"

struct MeshBlock {
    uint first_point, point_room, first_index, index_room;  // where its own are, and how many there may be
    uint index_count;
    uint seen;                // by which eyes: a bit each
    uint cells_of, points_of; // sums of the samples that these were built of; 0: there are none
};

struct Draw {
    uint index_count, instances, first_index, base_vertex, eye;
};

layout(std430, binding = 0) buffer MeshCounts {
    uint point_count, index_count;  // that there would be if there were room
    uint draw_count;
    uint listed[2];
    uint groups[6];  // of passes over the lists: three numbers each
    int forgotten;   // the forget_number (mesh_begin.glsl) of what is counted
};
layout(std430, binding = 2) buffer MeshBlocks {
    MeshBlock blocks[];
};
layout(std430, binding = 3) buffer MeshLists {
    uint lists[];  // of blocks: the first half has those whose cells are built, the second those whose points are
};
const uint CELLS = 0u, POINTS_OF_CELLS = 1u;
const uint MAX_GROUPS_IN_ROW = 1024u;  // drivers need not take more than 65,535

uint block_count() {
    return uint(block_grid.x * block_grid.y);
}

#ifdef BUILDS
/// Of a work group; false: it has none.
bool find_listed(uint list, out uint block) {
    uint i = gl_WorkGroupID.y * MAX_GROUPS_IN_ROW + gl_WorkGroupID.x;
    if (i >= listed[list])
        return false;
    block = lists[list * block_count() + i];
    return true;
}

/// Bits of the points of a block that are corners of its cells: a word for each row but for its last point, whose bits
/// are in the last two words.
layout(std430, binding = 4) buffer MeshCorners {
    uint corners[];
};
const int CORNER_WORDS = POINTS + 2;

uint corner_bits_of(uint block, int row) {
    return corners[block * uint(CORNER_WORDS) + uint(row)];
}
uint corner_of(uint block, ivec2 p) {
    return p.x < SIDE ? corner_bits_of(block, p.y) >> p.x & 1u : corner_bits_of(block, POINTS + (p.y >> 5)) >> (p.y & 31) & 1u;
}

// Where no cell begins, 0; else 1 + log2 of its side, or of one whose corners are not all joined CUT, and in the upper
// four bits whether corner i is joined to the next; UPPER or LOWER where there is one triangle alone.
layout(binding = 0, r8ui) uniform uimage2D mesh_cells;
const uint CUT = 7u, UPPER = 8u, LOWER = 9u;
#endif
