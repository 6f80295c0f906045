#include "eye_depth_from_source.h"
#include "mesh_triangles.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <cmath>

namespace equistream {

namespace {

struct VisibleBlock {
    int block_x = 0, block_y = 0;
    MeshCells cells;
    BlockTriangles triangles;
};

class MeshFinder : public EyeDepthFromSource {
public:
    explicit MeshFinder(bool plain) : plain_(plain) {}

    void find(const FindingTask& task, FloatImage& inverse_planar) const override {
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
            if (plain_)
                build_plain_cells(scratch.block, blocks[i].cells);
            else
                build_mesh_cells(scratch.block, scratch.joined, within, blocks[i].cells);
        });
        const EyeProjection projection(task.eye.camera, task.eye.pose, task.source.pose);
        const Neighbourhood neighbourhood(task.lattice, blocks);
        tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
            const Scratch& scratch = load(blocks[i]);
            make_triangles({scratch.block, scratch.joined, projection, plain_}, blocks[i].cells,
                           neighbourhood.of(blocks[i]), blocks[i].triangles);
        });
        draw(blocks, inverse_planar);
    }

private:
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
                    y > 0 ? at_[index(x, y - 1)] : nullptr,
                    y + 1 < lattice_.block_rows() ? at_[index(x, y + 1)] : nullptr};
        }

    private:
        std::size_t index(int x, int y) const {
            return std::size_t(y) * std::size_t(lattice_.block_columns()) + std::size_t(x);
        }
        const SourceLattice& lattice_;
        std::vector<const MeshCells*> at_;
    };

    static std::vector<VisibleBlock> visible_blocks(const FindingTask& task) {
        const PixelBox everything{0, 0, task.eye.camera.width, task.eye.camera.height};
        const SeenThrough seen(task.eye.camera, task.eye.pose, task.source.pose, everything);
        std::vector<VisibleBlock> blocks;
        for (int y = 0; y < task.lattice.block_rows(); ++y)
            for (int x = 0; x < task.lattice.block_columns(); ++x)
                if (seen.may_show(task.lattice.summary(x, y)))
                    blocks.push_back({x, y, {}, {}});
        return blocks;
    }

    static void draw(const std::vector<VisibleBlock>& blocks, FloatImage& inverse_planar) {
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

    bool plain_;
};

}  // namespace

std::unique_ptr<EyeDepthFromSource> make_mesh_finder(bool plain) {
    return std::make_unique<MeshFinder>(plain);
}

}  // namespace equistream
