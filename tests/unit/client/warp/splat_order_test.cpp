#include <tests/unit/client/engine_scenes.h>

#include <client/warp/splat_order.h>

#include <gtest/gtest.h>

namespace equistream::test {
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
