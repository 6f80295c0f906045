#include <client/warp/source_lattice.h>

#include <gtest/gtest.h>

#include <random>

namespace equistream::test {
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
}  // namespace equistream::test
