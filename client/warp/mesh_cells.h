#pragma once
/// A block of a source's lattice as a quadtree of cells, each so large as keeps w = B / (r - B) within a tolerance of
/// the two triangles that stand for it, none across a cut.
#include "source_lattice.h"

#include <cstdint>
#include <vector>

namespace equistream {

struct MeshCell {
    std::uint8_t x, y;  ///< of its first corner, in the block
    std::uint8_t side;  ///< 1, 2, 4, ... cells of the lattice
    bool whole;         ///< false only where side is 1: some of its corners are not joined
};

struct MeshCells {
    std::vector<MeshCell> cells;
    /// Bit x of row y: the lattice point is a corner of some cell. Cells that end on an edge between blocks know
    /// their own side only.
    std::array<std::uint64_t, LatticeBlock::side + 1> corners{};

    bool is_corner(int x, int y) const { return corners[std::size_t(y)] >> x & 1; }
};

/// `within`: how far a cell may be off, for any eye of its box. The mesh's storage is reused.
void build_mesh_cells(const LatticeBlock& block, const JoinedPoints& joined, const DepthAgreement& within,
                      MeshCells& mesh);

/// Every cell of the lattice, whole.
void build_plain_cells(const LatticeBlock& block, MeshCells& mesh);

}  // namespace equistream
