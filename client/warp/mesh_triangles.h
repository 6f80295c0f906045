#pragma once
/// The triangles of a block's cells as an eye sees them.
#include "eye_projection.h"
#include "mesh_cells.h"
#include "triangle_raster.h"

#include <array>
#include <cstdint>
#include <vector>

namespace equistream {

/// Triangles of one block before the eye, clockwise, and the rows of its picture that they reach.
struct BlockTriangles {
    std::vector<ScreenVertex> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    float top = 0, bottom = 0;
};

/// The cells around a block; null where none are drawn. A corner of theirs on a common edge is one of ours too, so that
/// no crack opens between cells of different sizes.
struct NeighbourCells {
    const MeshCells* left = nullptr;
    int left_columns = 0;  ///< of the left one
    const MeshCells* right = nullptr;
    const MeshCells* above = nullptr;
    const MeshCells* below = nullptr;
};

/// A block as an eye sees it.
struct SeenBlock {
    const LatticeBlock& block;
    const JoinedPoints& joined;
    const EyeProjection& projection;
    bool both_sides = false;  ///< keep what the eye sees from behind
};

void make_triangles(const SeenBlock& seen, const MeshCells& cells, const NeighbourCells& neighbours,
                    BlockTriangles& out);

}  // namespace equistream
