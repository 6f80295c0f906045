#include <equistream/bound.h>

#include <client/warp/mesh.h>
#include <client/warp/source_lattice.h>
#include <client/warp/splat_order.h>
#include <tests/unit/client/engine_scenes.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <ranges>

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

/// What is cut leads on beyond its samples, also by the step to one beside the block.
TEST(Lattice, SummariesHoldWhatCellsLeadOnTo) {
    const PerspectiveCamera camera{100, 70, 1.2};
    FloatImage depth_m(100, 70, 1, 4.0f);
    const SourceLattice flat(camera, depth_m.view());
    for (int y = 0; y < flat.block_rows(); ++y)
        for (int x = 0; x < flat.block_columns(); ++x) {
            EXPECT_EQ(flat.summary(x, y).nearest_inverse_m, 0.25f) << x << ' ' << y;
            EXPECT_EQ(flat.summary(x, y).farthest_inverse_m, 0.25f) << x << ' ' << y;
        }
    // The first block ends on column 31; what is nearer stands in 32 alone.
    std::ranges::for_each(std::views::iota(0, 70), [&](int y) { *depth_m.pixel(32, y) = 2; });
    const SourceLattice stepped(camera, depth_m.view());
    EXPECT_GE(stepped.summary(0, 0).nearest_inverse_m, 0.5f + 0.5f * (0.5f - 0.25f));
    EXPECT_LE(stepped.summary(0, 0).farthest_inverse_m, 0.25f - 0.5f * (0.5f - 0.25f));
    EXPECT_EQ(stepped.summary(2, 0).nearest_inverse_m, 0.25f) << "far from it";
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

namespace {

/// A room's depths, rough enough that about every other neighbour is another surface.
FloatImage rough_depth(int width, int height) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> beside_m(-0.2f, 0.2f);
    FloatImage depth_m(width, height, 1);
    for (float& r : depth_m.samples())
        r = 2 + beside_m(random);
    return depth_m;
}

/// Blocks know of each point what the whole lattice says, at their ends too.
TEST(SourceLattice, BlocksJoinWhatTheLatticeJoins) {
    for (const Camera& camera : {Camera(EquirectCamera{128, 64, {}}), Camera(PerspectiveCamera{150, 71, 1.6}),
                                 Camera(EquirectCamera{100, 50, {-2.4, 2.1, -1.2, 1.3}})}) {
        SCOPED_TRACE(width_of(camera));
        const FloatImage depth_m = rough_depth(width_of(camera), height_of(camera));
        const SourceLattice lattice(camera, depth_m.view());
        const DepthAgreement same{0.0315f, 2e-3f};
        const auto joins = [&](int x, int y, int right, int down) {
            const auto k = [&](int i) { return lattice.point(x + i * right, y + i * down).k; };
            return same.connected(k(-1), k(0), k(1), k(2));
        };
        LatticeBlock block;
        JoinedPoints joined;
        std::array<int, 2> counts{};
        for (int by = 0; by < lattice.block_rows(); ++by)
            for (int bx = 0; bx < lattice.block_columns(); ++bx) {
                lattice.load(bx, by, block);
                find_joined(block, same, joined);
                for (int y = -1; y <= LatticeBlock::side; ++y)
                    for (int x = -1; x <= LatticeBlock::side; ++x) {
                        const int i = LatticeBlock::at(x, y);
                        const bool right = joins(block.x0 + x, block.y0 + y, 1, 0);
                        ASSERT_EQ(joined.right[i] != 0, right) << "block " << bx << ' ' << by << ": " << x << ' ' << y;
                        ASSERT_EQ(joined.down[i] != 0, joins(block.x0 + x, block.y0 + y, 0, 1))
                            << "block " << bx << ' ' << by << ": " << x << ' ' << y;
                        ++counts[right];
                    }
            }
        EXPECT_GT(counts[0], 1000);
        EXPECT_GT(counts[1], 1000);
    }
}

}  // namespace

namespace {

/// Whether the sample at `a` is drawn before the one at `b`.
bool earlier(const SplatOrder& order, glm::dvec2 a, glm::dvec2 b) {
    const int column_a = int(a.x), column_b = int(b.x);
    if (column_a != column_b)
        return order.earliness(column_a) > order.earliness(column_b);
    const double turn = order.turning_row(column_a);
    const double to_a = std::floor(a.y) + 0.5 - turn, to_b = std::floor(b.y) + 0.5 - turn;
    return order.towards_turning_row(column_a) ? std::abs(to_a) > std::abs(to_b) : std::abs(to_a) < std::abs(to_b);
}

/// Of two points on one ray of an eye, the farther one's sample must be drawn first. Points in one pixel, and rows of
/// one column on either side of its turning row (which no ray joins but within a pixel), do not count.
TEST(SplatOrder, FartherPointsOnARayComeFirst) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> one(0, 1);
    for (const Camera& camera : {Camera(EquirectCamera{360, 180, {}}), Camera(PerspectiveCamera{300, 200, 1.9}),
                                 Camera(EquirectCamera{200, 100, {-2, 2.2, -1.1, 1.3}})}) {
        int compared = 0, wrong = 0;
        for (int i = 0; i < 200; ++i) {
            const glm::dvec3 eye = random_eye(random, 0.5).position_m;
            const SplatOrder order(camera, eye);
            for (int j = 0; j < 500; ++j) {
                const glm::dvec3 ray = random_eye(random, 1).position_m;
                const double near_m = 0.2 + 3 * one(random), far_m = near_m * (1.05 + 5 * one(random));
                const glm::dvec2 near = pixel_of(camera, eye + near_m * glm::normalize(ray));
                const glm::dvec2 far = pixel_of(camera, eye + far_m * glm::normalize(ray));
                const auto inside = [&](glm::dvec2 p) {
                    return p.x >= 0 && p.y >= 0 && p.x < width_of(camera) && p.y < height_of(camera);
                };
                if (!inside(near) || !inside(far) || glm::floor(near) == glm::floor(far))
                    continue;
                const double turn = order.turning_row(int(near.x));
                const bool one_column = std::floor(near.x) == std::floor(far.x);
                if (one_column && std::abs(near.y - turn) < 2)
                    continue;
                ++compared;
                wrong += !earlier(order, far, near);
            }
        }
        EXPECT_GT(compared, 3000);
        EXPECT_LE(wrong, compared / 1000) << "of " << compared;
    }
}

}  // namespace
}  // namespace equistream::test
