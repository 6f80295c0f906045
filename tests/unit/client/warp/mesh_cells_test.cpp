#include <tests/unit/client/engine_scenes.h>

#include <client/warp/mesh.h>

#include <equistream/bound.h>

#include <gtest/gtest.h>

namespace equistream::test {
namespace {

using glm::dvec3;

constexpr double box_m = 0.0315;

std::int64_t cells_of(const Distance& distance, const Camera& camera, double tolerance_rad) {
    const FloatImage depth_m = [&] {
        FloatImage plane(width_of(camera), height_of(camera), 1);
        AnalyticDepth(distance).cast(camera, Pose{}, plane.view());
        return plane;
    }();
    const SourceLattice lattice(camera, depth_m.view());
    const DepthAgreement same{float(box_m), float(4 * tolerance_rad)};
    LatticeBlock block;
    JoinedPoints joined;
    MeshCells cells;
    std::int64_t count = 0, area = 0;
    for (int y = 0; y < lattice.block_rows(); ++y)
        for (int x = 0; x < lattice.block_columns(); ++x) {
            lattice.load(x, y, block);
            find_joined(block, same, joined);
            build_mesh_cells(block, joined, {float(box_m), float(tolerance_rad)}, cells);
            count += std::int64_t(cells.cells.size());
            for (const MeshCell& cell : cells.cells)
                area += std::int64_t(cell.side) * cell.side;
        }
    // Every cell of the lattice is covered once.
    const int columns = lattice.width() - lattice.first_column();
    EXPECT_EQ(area, std::int64_t(columns) * (lattice.height() + 1));
    return count;
}

/// What a plane is seen through a perspective picture needs one cell a block, however tilted.
TEST(MeshCells, APlaneNeedsOneCellABlock) {
    const PerspectiveCamera camera{319, 255, 1.6};
    for (const dvec3& normal : {dvec3(0, 0, 1), dvec3(0.6, 0.2, 1), dvec3(-0.1, 0.3, 0.9)}) {
        const Distance plane = [&](const dvec3& o, const dvec3& d) { return to_plane(o, d, normal, -2); };
        // 320 x 256 cells, edges included.
        EXPECT_EQ(cells_of(plane, camera, error_budget_rad(960) / 4), 10 * 8) << normal.x;
    }
}

/// A ball needs smaller cells the smaller the error: a chord's error falls with the square of a cell's side.
TEST(MeshCells, CellsGrowWithTheTolerance) {
    const EquirectCamera camera{960, 480, {}};
    const Distance ball = [](const dvec3& o, const dvec3& d) { return to_sphere(o, d, {0.2, 0.1, 0}, 0.8); };
    const std::int64_t fine = cells_of(ball, camera, error_budget_rad(960) / 64);
    const std::int64_t middling = cells_of(ball, camera, error_budget_rad(960) / 8);
    const std::int64_t coarse = cells_of(ball, camera, error_budget_rad(960));
    EXPECT_GT(fine, 2 * middling);
    EXPECT_GT(middling, 2 * coarse);
    EXPECT_LT(fine, 960 * 480 / 4);
}

/// Before a ball's rim the wall behind it is another surface: no cell but a cut one has corners on both.
TEST(MeshCells, NoCellSpansAnEdge) {
    const EquirectCamera camera{480, 240, {}};
    const SurfaceScene scene = furnished();
    FloatImage depth_m(camera.width, camera.height, 1);
    AnalyticDepth(scene).cast(camera, Pose{}, depth_m.view());
    const SourceLattice lattice(camera, depth_m.view());
    LatticeBlock block;
    JoinedPoints joined;
    MeshCells cells;
    const float budget = float(error_budget_rad(960));
    const DepthAgreement same{float(box_m), budget};
    std::int64_t cut = 0, wide = 0;
    for (int y = 1; y + 1 < lattice.block_rows(); ++y)
        for (int x = 0; x < lattice.block_columns(); ++x) {
            lattice.load(x, y, block);
            find_joined(block, same, joined);
            build_mesh_cells(block, joined, {float(box_m), budget / 8}, cells);
            for (const MeshCell& cell : cells.cells) {
                cut += !cell.whole;
                wide += cell.side > 4;
                if (cell.side == 1)
                    continue;
                // Every sample of a wide cell lies between its corners, give or take the tolerance.
                float low = 1e9f, high = 0;
                for (const int j : {0, int(cell.side)})
                    for (const int i : {0, int(cell.side)}) {
                        low = std::min(low, block.point(cell.x + i, cell.y + j).k);
                        high = std::max(high, block.point(cell.x + i, cell.y + j).k);
                    }
                for (int j = 0; j <= cell.side; ++j)
                    for (int i = 0; i <= cell.side; ++i) {
                        const float k = block.point(cell.x + i, cell.y + j).k;
                        ASSERT_TRUE(formulas::between_inverse(low, high, k, same.box_radius_m, same.tolerance))
                            << k << " from " << low << " to " << high;
                    }
            }
        }
    EXPECT_GT(cut, 300);
    EXPECT_GT(wide, 200);
}

}  // namespace
}  // namespace equistream::test
