#include "mesh.h"

#include "source_depth_engine.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

struct VisibleBlock {
    int block_x = 0, block_y = 0;
    MeshCells cells;
    BlockTriangles triangles;
};

/// Finds the cells around a block.
class Neighbourhood {
public:
    Neighbourhood(const SourceLattice& lattice, const std::vector<VisibleBlock>& blocks) : lattice_(lattice) {
        at_.resize(std::size_t(lattice.block_columns()) * std::size_t(lattice.block_rows()));
        for (const VisibleBlock& block : blocks)
            at_[index(block.block_x, block.block_y)] = &block.cells;
    }
    NeighbourCells of(const VisibleBlock& block) const {
        const int x = block.block_x, y = block.block_y, columns = lattice_.block_columns();
        const int left = x > 0 ? x - 1 : lattice_.closes() ? columns - 1 : -1;
        const int right = x + 1 < columns ? x + 1 : lattice_.closes() ? 0 : -1;
        const int left_columns =
            std::min(LatticeBlock::side, lattice_.width() - lattice_.first_column() - left * LatticeBlock::side);
        return {left < 0 ? nullptr : at_[index(left, y)], left_columns, right < 0 ? nullptr : at_[index(right, y)],
                y > 0 ? at_[index(x, y - 1)] : nullptr, y + 1 < lattice_.block_rows() ? at_[index(x, y + 1)] : nullptr};
    }

private:
    std::size_t index(int x, int y) const {
        return std::size_t(y) * std::size_t(lattice_.block_columns()) + std::size_t(x);
    }
    const SourceLattice& lattice_;
    std::vector<const MeshCells*> at_;
};

std::vector<VisibleBlock> visible_blocks(const FindingTask& task) {
    const PixelBox everything{0, 0, task.eye.camera.width, task.eye.camera.height};
    const SeenThrough seen(task.eye.camera, task.eye.pose, task.source.pose, everything);
    std::vector<VisibleBlock> blocks;
    for (int y = 0; y < task.lattice.block_rows(); ++y)
        for (int x = 0; x < task.lattice.block_columns(); ++x)
            if (seen.may_show(task.lattice.summary(x, y)))
                blocks.push_back({x, y, {}, {}});
    return blocks;
}

void draw(const std::vector<VisibleBlock>& blocks, FloatImage& inverse_planar) {
    constexpr int band_rows = 64;
    const int height = inverse_planar.height();
    tbb::parallel_for(0, (height + band_rows - 1) / band_rows, [&](int band) {
        const int first = band * band_rows, end = std::min(first + band_rows, height);
        for (const VisibleBlock& block : blocks) {
            const BlockTriangles& of = block.triangles;
            if (of.bottom < float(first - 1) || of.top > float(end))
                continue;
            for (const auto& [a, b, c] : of.triangles)
                draw_triangle(of.vertices[a], of.vertices[b], of.vertices[c], first, end, inverse_planar);
        }
    });
}

}  // namespace

void find_by_mesh(const FindingTask& task, bool plain, FloatImage& inverse_planar) {
    std::vector<VisibleBlock> blocks = visible_blocks(task);
    struct Scratch {
        LatticeBlock block;
        JoinedPoints joined;
    };
    tbb::enumerable_thread_specific<Scratch> scratches;
    const auto load = [&](const VisibleBlock& visible) -> Scratch& {
        Scratch& scratch = scratches.local();
        task.lattice.load(visible.block_x, visible.block_y, scratch.block);
        find_joined(scratch.block, task.same_surface, scratch.joined);
        return scratch;
    };
    // Half of what the mesh may be off: cells that are fanned out to meet smaller ones leave their own triangles by
    // as much again.
    const DepthAgreement within{task.same_surface.box_radius_m, 0.5f * task.share};
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
        const Scratch& scratch = load(blocks[i]);
        if (plain)
            build_plain_cells(scratch.block, blocks[i].cells);
        else
            build_mesh_cells(scratch.block, scratch.joined, within, blocks[i].cells);
    });
    const EyeProjection projection(task.eye.camera, task.eye.pose, task.source.pose);
    const Neighbourhood neighbourhood(task.lattice, blocks);
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
        const Scratch& scratch = load(blocks[i]);
        make_triangles({scratch.block, scratch.joined, projection, plain}, blocks[i].cells, neighbourhood.of(blocks[i]),
                       blocks[i].triangles);
    });
    draw(blocks, inverse_planar);
}

namespace {

constexpr int side = LatticeBlock::side;

/// The plane through three points, as m of 1/r = m . q. In double precision: the points lie close together, and what is
/// wanted is their small differences.
glm::vec3 plane_through(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
    const glm::dvec3 origin(a.q);
    const double square = glm::dot(origin, origin);
    const auto chord = [&](const LatticePoint& p) { return glm::dvec3(p.q) - origin; };
    // m = k q_a / |q_a|^2 + s u + t v: right at a because u and v are square to q_a, at b and c by the choice of s and
    // t.
    const double k = a.k / square;
    const auto across = [&](const glm::dvec3& d) { return d - glm::dot(d, origin) / square * origin; };
    const glm::dvec3 u = across(chord(b)), v = across(chord(c));
    const double at_u = b.k - a.k - k * glm::dot(origin, chord(b));
    const double at_v = c.k - a.k - k * glm::dot(origin, chord(c));
    const double uu = glm::dot(u, u), vv = glm::dot(v, v), uv = glm::dot(u, v);
    const double determinant = uu * vv - uv * uv;
    const double s = (at_u * vv - at_v * uv) / determinant, t = (at_v * uu - at_u * uv) / determinant;
    return glm::vec3(k * origin + s * u + t * v);
}

/// Builds bottom-up: a node is flat if its four parts are and its two triangles hold all its points.
class CellTree {
public:
    CellTree(const LatticeBlock& block, const JoinedPoints& joined, const DepthAgreement& within)
        : block_(block), within_(within) {
        for (int y = 0; y < block.rows; ++y)
            for (int x = 0; x < block.columns; ++x) {
                const int i = LatticeBlock::at(x, y);
                flat_[0][y * side + x] =
                    joined.right[i] & joined.right[i + LatticeBlock::stride] & joined.down[i] & joined.down[i + 1];
            }
        for (int level = 1; level <= levels; ++level)
            build(level);
    }

    void collect(MeshCells& mesh) const { collect(levels, 0, 0, mesh); }

private:
    static constexpr int levels = 5;
    static_assert(1 << levels == side);

    bool fits(int x, int y, int size) const { return x + size <= block_.columns && y + size <= block_.rows; }

    void build(int level) {
        const int size = 1 << level, half = size / 2;
        const auto& below = flat_[level - 1];
        for (int y = 0; y < block_.rows; y += size)
            for (int x = 0; x < block_.columns; x += size)
                flat_[level][(y >> level) * side + (x >> level)] =
                    fits(x, y, size) && below[(y / half) * side + x / half] &&
                    below[(y / half) * side + x / half + 1] && below[(y / half + 1) * side + x / half] &&
                    below[(y / half + 1) * side + x / half + 1] && holds(x, y, size);
    }

    /// Both triangles of a cell, split from its first corner to the opposite one.
    bool holds(int x, int y, int size) const {
        const LatticePoint a = block_.point(x, y), b = block_.point(x + size, y);
        const LatticePoint c = block_.point(x, y + size), d = block_.point(x + size, y + size);
        const glm::vec3 upper = plane_through(a, b, d), lower = plane_through(a, d, c);
        for (int j = 0; j <= size; ++j)
            if (!row_holds(x, y + j, {0, j}, lower) || !row_holds(x, y + j, {j, size}, upper))
                return false;
        return true;
    }

    struct Columns {
        int first, last;
    };
    bool row_holds(int x, int y, Columns columns, const glm::vec3& plane) const {
        const int begin = LatticeBlock::at(x, y);
        bool good = true;
        for (int i = begin + columns.first; i <= begin + columns.last; ++i) {
            const float k = plane.x * block_.qx[i] + plane.y * block_.qy[i] + plane.z * block_.qz[i];
            good &= within_.same_inverse(k, block_.k[i]);
        }
        return good;
    }

    void collect(int level, int x, int y, MeshCells& mesh) const {
        if (x >= block_.columns || y >= block_.rows)
            return;
        const int size = 1 << level;
        const bool flat = flat_[level][(y >> level) * side + (x >> level)] != 0;
        if (!flat && level > 0) {
            const int half = size / 2;
            collect(level - 1, x, y, mesh);
            collect(level - 1, x + half, y, mesh);
            collect(level - 1, x, y + half, mesh);
            collect(level - 1, x + half, y + half, mesh);
            return;
        }
        mesh.cells.push_back({std::uint8_t(x), std::uint8_t(y), std::uint8_t(size), flat});
        const std::uint64_t both = std::uint64_t{1} << x | std::uint64_t{1} << (x + size);
        mesh.corners[std::size_t(y)] |= both;
        mesh.corners[std::size_t(y + size)] |= both;
    }

    const LatticeBlock& block_;
    DepthAgreement within_;
    std::array<std::array<std::uint8_t, side * side>, levels + 1> flat_{};
};

}  // namespace

void build_mesh_cells(const LatticeBlock& block, const JoinedPoints& joined, const DepthAgreement& within,
                      MeshCells& mesh) {
    mesh.cells.clear();
    mesh.corners = {};
    CellTree(block, joined, within).collect(mesh);
}

void build_plain_cells(const LatticeBlock& block, MeshCells& mesh) {
    mesh.cells.clear();
    mesh.corners = {};
    for (int y = 0; y < block.rows; ++y)
        for (int x = 0; x < block.columns; ++x)
            mesh.cells.push_back({std::uint8_t(x), std::uint8_t(y), 1, true});
}

}  // namespace equistream
