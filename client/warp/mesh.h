#pragma once
/// The adaptive mesh of a source's lattice: cells, their triangles, and these into a plane of depths.
#include "eye_rays.h"
#include "source_lattice.h"

#include <equistream/image.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace equistream {

// A block of a source's lattice as a quadtree of cells, each so large as keeps w = B / (r - B) within a tolerance of
// the two triangles that stand for it, none across a cut.

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

// Triangles into a plane of inverse planar depths: the nearest wins, whatever their order.

struct ScreenVertex {
    float x = 0, y = 0;  ///< pixel centres are whole numbers
    float inverse_planar = 0;
};

/// Twice the area; positive if the corners come clockwise in a picture whose rows run down.
inline float twice_area(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Against pixels between two triangles that fall to neither by rounding; a pixel that falls to both is no harm.
inline constexpr float raster_slack_px = 1.0f / 512;

/// Corners clockwise. Only rows from `first_row` to before `end_row` are touched.
inline void draw_triangle(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, int first_row,
                          int end_row, FloatImage& nearest) {
    const auto [top, bottom] = std::minmax({a.y, b.y, c.y});
    const int y0 = std::max(int(std::ceil(top - raster_slack_px)), first_row);
    const int y1 = std::min(int(std::floor(bottom + raster_slack_px)), end_row - 1);
    if (y0 > y1)
        return;
    const auto [left, right] = std::minmax({a.x, b.x, c.x});
    const float min_x = std::max(left - raster_slack_px, 0.0f);
    const float max_x = std::min(right + raster_slack_px, float(nearest.width() - 1));
    const float inverse_area = 1 / twice_area(a, b, c);
    const float slope_x =
        ((b.inverse_planar - a.inverse_planar) * (c.y - a.y) - (c.inverse_planar - a.inverse_planar) * (b.y - a.y)) *
        inverse_area;
    const float slope_y =
        ((c.inverse_planar - a.inverse_planar) * (b.x - a.x) - (b.inverse_planar - a.inverse_planar) * (c.x - a.x)) *
        inverse_area;
    const auto [low, high] = std::minmax({a.inverse_planar, b.inverse_planar, c.inverse_planar});
    struct Side {
        float x, y, slope, slack;
        bool is_left, is_level;
    };
    const auto side = [](const ScreenVertex& p, const ScreenVertex& q) -> Side {
        const float dy = q.y - p.y;
        const float slope = dy == 0 ? 0 : (q.x - p.x) / dy;
        return {p.x, p.y, slope, raster_slack_px * (1 + std::abs(slope)), dy < 0, dy == 0};
    };
    const Side sides[3] = {side(a, b), side(b, c), side(c, a)};
    for (int y = y0; y <= y1; ++y) {
        float from = min_x, to = max_x;
        for (const Side& s : sides) {
            if (s.is_level)
                continue;
            const float x = s.x + s.slope * (float(y) - s.y);
            if (s.is_left)
                from = std::max(from, x - s.slack);
            else
                to = std::min(to, x + s.slack);
        }
        const int x0 = int(std::ceil(from)), x1 = int(std::floor(to));
        float* row = nearest.pixel(0, y);
        const float start = a.inverse_planar + slope_y * (float(y) - a.y) - slope_x * a.x;
        for (int x = x0; x <= x1; ++x)
            row[x] = std::max(row[x], std::clamp(start + slope_x * float(x), low, high));
    }
}

// The triangles of a block's cells as an eye sees them.

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
