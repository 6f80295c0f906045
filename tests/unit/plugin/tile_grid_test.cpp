/// Tiles: where they are on their sphere, and which of them a view meets.
#include <equistream/camera_limits.h>
#include <equistream/window.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace equistream {
namespace {

TEST(Tiles, cover_the_sphere_once) {
    EXPECT_FALSE(tile_problem(1920, {8, 4}));
    for (const TileGrid& tiles : {TileGrid{8, 4}, {2, 1}, {24, 4}}) {
        const WindowGrid grid = tile_grid(768, tiles);
        ASSERT_FALSE(tile_problem(768, tiles));
        std::vector<int> covered(768 * 384);
        for (int tile = 0; tile < tiles.count(); ++tile) {
            const WindowPlace place = tile_place(grid, tiles, tile);
            EXPECT_FALSE(window_place_problem(grid, place));
            EXPECT_EQ(window_place(grid, window_camera(grid, place).range), place);
            EXPECT_FALSE(camera_mismatch(window_camera(grid, place)));
            for (int y = place.y; y < place.y + grid.height; ++y)
                for (int x = place.x; x < place.x + grid.width; ++x)
                    ++covered[std::size_t(y * 768 + x)];
        }
        EXPECT_EQ(std::ranges::count(covered, 1), 768 * 384);
    }
    EXPECT_EQ(tile_place(tile_grid(1920, {8, 4}), {8, 4}, 11), (WindowPlace{720, 240})) << "rows from the top";
}

TEST(Tiles, problems_are_named) {
    const std::string two = "tiles: expected at least 2 across and 1 down, found ",
                      divide = "tiles: expected numbers that divide 1920x960 pixels into multiples of 16, found ";
    for (const TileGrid& few : {TileGrid{1, 1}, {1, 4}, {0, 4}, {8, 0}, {-8, -4}})
        EXPECT_EQ(tile_problem(1920, few), two + size_text(few.columns, few.rows));
    for (const TileGrid& uneven : {TileGrid{7, 3}, {16, 4}, {8, 8}, {240, 60}, {1920, 960}, {100000, 1}})
        EXPECT_EQ(tile_problem(1920, uneven), divide + size_text(uneven.columns, uneven.rows));
    EXPECT_TRUE(tile_problem(1000, {4, 2}));
}

/// Of a view that shows all that is less than so far to the sides and above or below.
ViewExtent extent(double half_width_degrees, double half_height_degrees) {
    return {std::tan(half_width_degrees * pi / 180), std::tan(half_height_degrees * pi / 180)};
}

/// Tiles of those of the sphere's directions, one to a degree, that lie within the view.
std::set<int> tiles_within(const TileGrid& tiles, const glm::dquat& sphere_from_view, const ViewExtent& extent) {
    constexpr int rows = 180;
    std::set<int> within;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < 2 * rows; ++x) {
            const double longitude = ((x + 0.5) / rows - 1) * pi, latitude = (0.5 - (y + 0.5) / rows) * pi;
            const glm::dvec3 d = glm::conjugate(sphere_from_view) *
                                 glm::dvec3(std::sin(longitude) * std::cos(latitude), std::sin(latitude),
                                            -std::cos(longitude) * std::cos(latitude));
            if (std::abs(d.x) <= -d.z * extent.half_width && std::abs(d.y) <= -d.z * extent.half_height)
                within.insert(y * tiles.rows / rows * tiles.columns + x * tiles.columns / (2 * rows));
        }
    return within;
}

std::set<int> tiles_seen(const TileGrid& tiles, const glm::dquat& sphere_from_view, const ViewExtent& extent) {
    std::set<int> seen;
    add_tiles_seen(tiles, sphere_from_view, extent, seen);
    return seen;
}

TEST(Tiles, that_a_view_meets_are_seen_and_no_others) {
    const TileGrid tiles{8, 4};
    const glm::dquat ahead(1, 0, 0, 0);
    const auto turned = [](double degrees, const glm::dvec3& around) {
        return glm::angleAxis(degrees * pi / 180, around);
    };
    EXPECT_EQ(tiles_seen(tiles, ahead, extent(44.9, 30)), (std::set{11, 12, 19, 20}));
    const std::set<int> up = tiles_seen(tiles, turned(90, {1, 0, 0}), extent(45, 30));
    for (int tile = 0; tile < 8; ++tile)
        EXPECT_TRUE(up.contains(tile)) << tile;
    EXPECT_LT(*up.rbegin(), 16) << "nothing below the horizon";
    EXPECT_EQ(tiles_seen(tiles, turned(180, {0, 1, 0}), extent(30, 20)), (std::set{8, 15, 16, 23})) << "the seam";
    EXPECT_EQ(tiles_seen(tiles, turned(90, {0, 0, 1}), extent(44.9, 10)), (std::set{11, 12, 19, 20})) << "rolled";
    EXPECT_EQ(tiles_seen(tiles, turned(90, {0, 0, 1}), extent(60, 10)).size(), 8u) << "rolled, from row to row";
    EXPECT_EQ(tiles_seen(tiles, turned(20, {0, 1, 0}), extent(10, 5)), (std::set{11, 19})) << "to the left";
    std::set<int> seen{31};
    add_tiles_seen(tiles, ahead, extent(10, 10), seen);
    EXPECT_TRUE(seen.contains(31)) << "they are added";
}

TEST(Tiles, of_any_view_are_seen) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> number(-1, 1), half(10, 88.9);
    for (const TileGrid& tiles : {TileGrid{8, 4}, {16, 7}, {32, 3}, {2, 1}, {60, 2}})
        for (int i = 0; i < 40; ++i) {
            const glm::dquat sphere_from_view =
                glm::normalize(glm::dquat(number(random), number(random), number(random), number(random)));
            const double across = half(random), down = half(random);
            const std::set<int> seen = tiles_seen(tiles, sphere_from_view, extent(across, down)),
                                all = tiles_within(tiles, sphere_from_view, widened(extent(across, down), 0.02)),
                                surely = tiles_within(tiles, sphere_from_view, extent(across - 6, down - 6));
            EXPECT_TRUE(std::ranges::includes(all, seen)) << size_text(tiles.columns, tiles.rows) << ", " << i;
            EXPECT_TRUE(std::ranges::includes(seen, surely)) << size_text(tiles.columns, tiles.rows) << ", " << i;
        }
}

TEST(Tiles, views_are_widened_below_90_degrees) {
    const ViewExtent wider = widened(extent(40, 30), 10 * pi / 180);
    EXPECT_NEAR(wider.half_width, std::tan(50 * pi / 180), 1e-12);
    EXPECT_NEAR(wider.half_height, std::tan(40 * pi / 180), 1e-12);
    for (const double degrees : {79.5, 85.0, 89.9})
        EXPECT_NEAR(widened(extent(degrees, 30), 10 * pi / 180).half_width, std::tan(89 * pi / 180), 1e-9);
    const PerspectiveCamera view{1200, 800, pi / 2};
    EXPECT_NEAR(extent_of(view).half_width, 1, 1e-12);
    EXPECT_NEAR(extent_of(view).half_height, 2.0 / 3, 1e-12);
}

}  // namespace
}  // namespace equistream
