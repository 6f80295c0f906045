#include <client/model/client_model.h>
#include <client/model/model_draft.h>
#include <client/model/ray_checks.h>
#include <equistream/bound.h>
#include <equistream/error.h>
#include <scenes/embree/bvh.h>
#include <scenes/embree/embree_rays.h>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <utility>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

const double error_rad = default_budget_share * error_budget_rad(default_focal_length_px);

/// A square of n x n quads, its corner, and its sides as vectors.
Mesh grid(const std::string& name, int n, const glm::vec3& corner, const glm::vec3& side_u, const glm::vec3& side_v) {
    Mesh mesh;
    mesh.name = name;
    mesh.material = 0;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            mesh.positions.push_back(corner + side_u * (float(i) / float(n)) + side_v * (float(j) / float(n)));
            mesh.uvs.emplace_back(float(i) / float(n), float(j) / float(n));
        }
    const auto at = [n](int i, int j) { return unsigned(j * (n + 1) + i); };
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
            mesh.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
    return mesh;
}

/// A ball whose triangles are far smaller than the bound asks for.
Mesh ball(const glm::vec3& centre, float radius, int n) {
    Mesh mesh = grid("ball", n, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    for (glm::vec3& p : mesh.positions) {
        const auto d = direction_from_longitude_latitude(2 * pi * (p.x < 1 ? p.x : 0), pi * (p.y - 0.5));
        p = centre + radius * glm::vec3(float(d.x), float(d.y), float(d.z));
    }
    return mesh;
}

void add(SceneModel& model, const Mesh& mesh, const glm::mat4& world_from_object = glm::mat4(1)) {
    model.instances.push_back(
        {std::uint32_t(model.meshes.size()), std::uint32_t(model.objects.size()), world_from_object});
    model.meshes.push_back(mesh);
    model.objects.push_back({mesh.name, -1, world_from_object});
}

/// A room of 10 m of finely divided walls with a ball in it, a ball behind a wall, a screen of which a mask leaves
/// the left half, and a block that moves before a picture on the wall.
class ClientModelTest : public testing::Test {
protected:
    fs::path folder = fs::temp_directory_path() / ("equistream_model_" + std::to_string(::getpid()));
    SceneModel model;
    SceneDescription scene;
    ClientModelOptions options{.error_rad = error_rad,
                               .silhouette_rad = error_rad / default_budget_share,
                               .visibility_rays = 1 << 21,
                               .check_rays = 1 << 17};

    void SetUp() override {
        model.materials.resize(2);
        const glm::vec3 x(10, 0, 0), y(0, 10, 0), z(0, 0, 10), low(-5, -5, -5), high(5, 5, 5);
        for (const Mesh& wall :
             {grid("floor", 40, low, x, z), grid("back", 40, low, x, y), grid("left", 40, low, y, z),
              grid("ceiling", 40, high, -x, -z), grid("front", 40, high, -x, -y), grid("right", 40, high, -y, -z)})
            add(model, wall);
        add(model, ball({2, 0, -3}, 1, 96));
        add(model, ball({8, 0, 0}, 1, 96));  // outside the room
        Mesh screen = grid("screen", 1, {-3, -1, -3}, {2, 0, 0}, {0, 2, 0});
        screen.material = 1;
        add(model, screen);
        AlphaMask mask{2, 1, Wrap::repeat, Wrap::clamp, {255, 0}};
        model.alpha_masks.push_back(mask);
        model.materials[1].name = "screen";
        model.materials[1].alpha_mask = 0;
        add(model, grid("block", 2, {-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}),
            glm::mat4({1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, -4.9f, 1}));
        const auto key = [](double time_s, const glm::dvec3& at) { return PosePath::Key{time_s, {at, {1, 0, 0, 0}}}; };
        scene.name = "room";
        scene.camera_path = PosePath({key(0, {-0.5, 0, 0}), key(1, {0.5, 0, 0.2})}, "test");
        scene.head_radius_m = 0.1;
        scene.geometry_fingerprint = "0123456789abcdef";
        scene.moving.push_back({"block", PosePath({key(0, {0, 0, -4.9}), key(1, {2, 0, -4.9})}, "test")});
        fs::create_directories(folder);
    }
    void TearDown() override { fs::remove_all(folder); }
};

double hit_distance(const Bvh& bvh, const glm::dvec3& from, const glm::dvec3& towards) {
    RTCRayHit ray = embree_ray_hit(glm::vec3(from), glm::vec3(towards));
    bvh.intersect1(ray);
    return double(ray.ray.tfar);
}

TEST_F(ClientModelTest, KeepsTheBoundWithFewerTriangles) {
    const ClientModel built = build_client_model(model, scene, options);
    EXPECT_TRUE(built.figures.holds);
    EXPECT_EQ(built.figures.triangles_before, model.triangle_count());
    EXPECT_EQ(built.figures.triangles_after, built.model.triangle_count());
    EXPECT_LT(built.figures.triangles_seen, 6 * 3200 + 96 * 96 * 2 + 2 + 8 + 1) << "what is outside the room";
    EXPECT_LT(built.model.triangle_count(), model.triangle_count() / 3);

    // Eyes and rays of this test's own, with the bound written out.
    const Bvh theirs(model), ours(built.model);
    const double box_m = scene.head_radius_m + 0.5 * default_ipd_m;
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> unit(0, 1);
    const auto direction = [&] { return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))); };
    int beyond = 0, far_beyond = 0;
    constexpr int rays = 200000;
    for (int i = 0; i < rays; ++i) {
        const glm::dvec3 centre = scene.camera_path.at(unit(random)).position_m;
        const glm::dvec3 eye = centre + box_m * std::cbrt(unit(random)) * direction(), towards = direction();
        const double r = hit_distance(theirs, eye, towards), used = hit_distance(ours, eye, towards);
        ASSERT_TRUE(std::isfinite(r)) << "the room is closed";
        const double shift = std::abs(box_m / (r - box_m) - box_m / (used - box_m));
        beyond += shift > error_rad;
        far_beyond += shift > 64 * error_rad;
    }
    EXPECT_LE(beyond, 3e-3 * rays) << "edges of the ball and of the screen";
    EXPECT_LE(far_beyond, 3e-4 * rays) << "the ball's outline: 1/4 px of 2 rad x 960 px around one of 4 pi";
}

/// A lamp that moves has no triangles. The block has moved before the camera begins, and stands still from then on.
TEST_F(ClientModelTest, IsReadAgainWithWhatMovesNothingAndWhatHasMovedBefore) {
    const auto key = [](double time_s, const glm::dvec3& at) { return PosePath::Key{time_s, {at, {1, 0, 0, 0}}}; };
    model.objects.push_back({"lamp", -1, glm::mat4(1)});
    scene.moving.push_back({"lamp", PosePath({key(0, {0, 1, 0}), key(1, {0, 2, 0})}, "test")});
    scene.moving.front().path = PosePath({key(-2, {0, 0, -4.9}), key(-1, {2, 0, -4.9})}, "test");
    write_client_model(folder / "room.json", build_client_model(model, scene, options), scene);
    const SceneDescription read = load_scene(folder / "room.json");
    ASSERT_EQ(read.moving.size(), 1u);
    EXPECT_EQ(find_moving_instances(load_model(read, {.shading = false}), read).size(), 1u);
    for (const double time_s : {-1.5, 0.0, 0.5})
        EXPECT_NEAR(read.moving.front().path.at(time_s).position_m.x, time_s < -1 ? 1 : 2, 1e-6) << time_s;
}

TEST_F(ClientModelTest, ALooserBoundKeepsFewerTriangles) {
    // Only the ball is curved; what its visible half borders on stays.
    const auto on_ball = [&] {
        const ClientModel built = build_client_model(model, scene, options);
        std::int64_t count = 0;
        for (const Mesh& mesh : built.model.meshes)
            count += std::ranges::count_if(mesh.triangles, [&](const glm::uvec3& t) {
                return glm::distance(mesh.positions[t.x], glm::vec3(2, 0, -3)) < 1.01f;
            });
        return count;
    };
    const std::int64_t tight = on_ball();
    options.error_rad *= 16;
    options.silhouette_rad *= 16;
    EXPECT_LT(on_ball(), tight / 2);
}

TEST_F(ClientModelTest, IsTheSameEachTimeAndAsItsFiles) {
    const ClientModel built = build_client_model(model, scene, options);
    const ClientModel again = build_client_model(model, scene, options);
    ASSERT_EQ(built.model.meshes.size(), again.model.meshes.size());
    for (std::size_t i = 0; i < built.model.meshes.size(); ++i)
        EXPECT_EQ(built.model.meshes[i].triangles, again.model.meshes[i].triangles);

    write_client_model(folder / "room.json", built, scene);
    const SceneDescription read = load_scene(folder / "room.json");
    EXPECT_EQ(read.stands_for, scene.geometry_fingerprint);
    EXPECT_EQ(read.depth_of_geometry(), scene.geometry_fingerprint);
    EXPECT_EQ(read.name, scene.name);
    EXPECT_EQ(read.head_radius_m, scene.head_radius_m);
    const SceneModel geometry = load_model(read, {.shading = false});
    EXPECT_EQ(geometry.triangle_count(), built.model.triangle_count());
    EXPECT_EQ(find_moving_instances(geometry, read).size(), 1u);
    ASSERT_EQ(geometry.alpha_masks.size(), 1u);
    EXPECT_EQ(geometry.alpha_masks[0].opaque, model.alpha_masks[0].opaque);

    const Bvh bvh(geometry, {.moving_instances = find_moving_instances(geometry, read)});
    EXPECT_NEAR(hit_distance(bvh, {-2.5, 0.1, 0}, {0, 0, -1}), 3, 1e-5) << "the screen's left half";
    EXPECT_NEAR(hit_distance(bvh, {-1.5, 0.1, 0}, {0, 0, -1}), 5, 1e-3) << "through its right half";
    EXPECT_NEAR(hit_distance(bvh, {0.1, 0.1, 0}, {0, 0, -1}), 4.9, 1e-5) << "the block";
}

TEST_F(ClientModelTest, WhatAMoverHidesIsKept) {
    const ClientModel built = build_client_model(model, scene, options);
    const std::vector<std::uint32_t> movers = find_moving_instances(built.model, scene);
    Bvh bvh(built.model, {.moving_instances = movers});
    bvh.move(instance_transforms(built.model, scene, 1));
    EXPECT_NEAR(hit_distance(bvh, {0.1, 0.1, 0}, {0, 0, -1}), 5, 1e-3);
    EXPECT_NEAR(hit_distance(bvh, {2.1, 2.1, 0}, {0, 0, -1}), 5, 1e-3);
    EXPECT_NEAR(hit_distance(bvh, {2.3, 0.2, -4.5}, {0, 0, -1}), 0.4, 1e-5);
}

/// What several objects share stays one mesh, of all that is seen of any, and as fine as the largest wants it.
TEST_F(ClientModelTest, WhatIsPlacedMoreThanOnceKeepsTheBoundToo) {
    const ClientModelFigures without = build_client_model(model, scene, options).figures;
    const Mesh shared = ball({0, 0, 0}, 0.6f, 64);
    const glm::vec3 places[] = {{-3, 1, 3}, {3, -2, 2.5f}};
    const float scales[] = {1, 2};
    const auto mesh = std::uint32_t(model.meshes.size());
    model.meshes.push_back(shared);
    for (int i = 0; i < 2; ++i) {
        const glm::mat4 placed = glm::scale(glm::translate(glm::mat4(1), places[i]), glm::vec3(scales[i]));
        model.instances.push_back({mesh, std::uint32_t(model.objects.size()), placed});
        model.objects.push_back({"placed", -1, placed});
    }
    const ClientModel built = build_client_model(model, scene, options);
    EXPECT_TRUE(built.figures.holds);
    EXPECT_EQ(built.figures.triangles_after, built.model.triangle_count());
    const auto more = double(built.figures.triangles_seen) - double(without.triangles_seen);
    EXPECT_GT(more, 0.6 * double(shared.triangles.size())) << "near halves of both, and what the head's way adds";
    EXPECT_LT(more, 1.9 * double(shared.triangles.size()));
    const Bvh theirs(model), ours(built.model);
    const double box_m = scene.head_radius_m + 0.5 * default_ipd_m;
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 400; ++k) {
            const double longitude = 0.7 * k, share = double(k) / 400;
            const glm::dvec3 beside = 0.5 * double(scales[i]) * share *
                                      glm::dvec3(std::cos(longitude), std::sin(longitude), std::cos(2 * longitude));
            const glm::dvec3 towards = glm::normalize(glm::dvec3(places[i]) + beside);
            const double r = hit_distance(theirs, {}, towards), used = hit_distance(ours, {}, towards);
            EXPECT_LT(std::abs(box_m / (r - box_m) - box_m / (used - box_m)), 2 * error_rad) << i << ", " << k;
        }
}

/// Of a triangle looked at square on, what its nearest point may; of one that stands on edge, a quarter of the box.
TEST(HeadBoxes, AllowWhatTheNearestPointMay) {
    constexpr double box_m = 0.1;
    const HeadBoxes boxes(PosePath({PosePath::Key{0, {}}}, "test"), box_m);
    const TriangleCorners ahead{{-1, -1, -5}, {1, -1, -5}, {0, 1, -5}};
    EXPECT_NEAR(boxes.distance_m(ahead), 5, 1e-9);
    EXPECT_NEAR(boxes.allowed_m(ahead, 5, error_rad), allowed_displacement_m(5, 1, box_m, error_rad), 1e-9);
    const TriangleCorners on_edge{{0, 0, -5}, {0, 0.1f, -5}, {0, 0, -5.1f}};
    EXPECT_NEAR(boxes.allowed_m(on_edge, 5, error_rad),
                allowed_displacement_m(5, 0.25 * box_m / 5.05, box_m, error_rad), 2e-2 * error_rad);
    EXPECT_EQ(boxes.allowed_m(ahead, box_m, error_rad), 0);
}

constexpr int keys_of_a_lap = 48;

/// Around a circle of 3 m.
PosePath laps(int count) {
    std::vector<PosePath::Key> keys;
    for (int i = 0; i <= keys_of_a_lap * count; ++i) {
        const double angle = 2 * pi * i / keys_of_a_lap;
        const glm::dvec3 at{3 * std::cos(angle), 1.6, 3 * std::sin(angle)};
        keys.push_back(PosePath::Key{double(i), {at, {1, 0, 0, 0}}});
    }
    return PosePath(std::move(keys), "test");
}

/// From any point of one lap to its nearest centre, at most.
double furthest_from_centres(const HeadBoxes& boxes, const PosePath& path) {
    double furthest = 0;
    for (int i = 0; i < 10 * keys_of_a_lap; ++i) {
        const glm::dvec3 point = path.at(0.1 * i).position_m;
        double nearest = std::numeric_limits<double>::infinity();
        for (const glm::dvec3& centre : boxes.centres())
            nearest = std::min(nearest, glm::distance(centre, point));
        furthest = std::max(furthest, nearest);
    }
    return furthest;
}

TEST(HeadBoxes, EyesOfALongWalkAreOnIt) {
    const HeadBoxes boxes(laps(191), 0.13);
    Random random(3);
    std::array<int, 4> in_quadrant{};
    for (int i = 0; i < 4000; ++i) {
        const glm::dvec3 centre = boxes.random_centre(random);
        EXPECT_NEAR(std::hypot(centre.x, centre.z), 3, 0.01) << "between keys 6 mm within the circle";
        ++in_quadrant[std::size_t((centre.x > 0) + 2 * (centre.z > 0))];
    }
    for (const int count : in_quadrant)
        EXPECT_NEAR(count, 1000, 150) << "five standard deviations";
}

TEST(HeadBoxes, APlaceThatALongWalkVisitsOnceHasItsShareOfEyes) {
    const PosePath walk = laps(191);
    std::vector<PosePath::Key> keys(walk.keys().begin(), walk.keys().end());
    keys.push_back(PosePath::Key{keys.back().time_s + 1, {{12, 1.6, 0}, {1, 0, 0, 0}}});
    const HeadBoxes boxes(PosePath(std::move(keys), "test"), 0.13);
    Random random(3);
    int beyond = 0;
    for (int i = 0; i < 4000; ++i)
        beyond += boxes.random_centre(random).x > 3.1;
    EXPECT_GT(beyond, 200) << "10 by its length alone";
}

TEST(HeadBoxes, LapsOfALongWalkCountOnce) {
    constexpr double radius_m = 0.13;
    const PosePath path = laps(191);
    const HeadBoxes one(laps(1), radius_m), all(path, radius_m);
    EXPECT_EQ(one.cell_m(), 0);
    EXPECT_EQ(all.cell_m(), radius_m);
    EXPECT_LT(all.centres().size(), 2 * one.centres().size());
    EXPECT_EQ(all.added_m(), 0);
    EXPECT_LT(furthest_from_centres(all, path), radius_m);
}

TEST(HeadBoxes, BallsAroundFewerCentresHoldAllHeadBoxes) {
    constexpr double radius_m = 0.13;
    const PosePath path = laps(20);
    const HeadBoxes fine(path, radius_m), coarse(path, radius_m, 40);
    EXPECT_LE(coarse.centres().size(), 40u);
    EXPECT_GT(coarse.cell_m(), radius_m);
    EXPECT_EQ(coarse.radius_m(), radius_m);
    EXPECT_LE(furthest_from_centres(coarse, path), coarse.added_m());
    EXPECT_LT(coarse.added_m(), 0.5 * std::sqrt(3.0) * coarse.cell_m() + 0.2 * radius_m);
    for (const glm::dvec3& point : coarse.points_on_path())
        EXPECT_NEAR(std::hypot(point.x, point.z), 3, 0.01);
    const TriangleCorners ahead{{-1, 0, -9}, {1, 0, -9}, {0, 2, -9}};
    EXPECT_LT(coarse.allowed_m(ahead, coarse.distance_m(ahead), error_rad),
              fine.allowed_m(ahead, fine.distance_m(ahead), error_rad));
}

/// The middles of the four cells lie within the pillar that the walk goes around.
TEST(VisibleTriangles, AreSeenFromThePathWhereCellsAreCoarse) {
    SceneModel model;
    model.materials.resize(1);
    const glm::vec3 x(4.2f, 0, 0), y(0, 4.2f, 0), z(0, 0, 4.2f);
    const glm::vec3 corner(-2.1f, -0.5f, -2.1f);
    add(model, grid("bottom", 1, corner + glm::vec3(0, 0.1f, 0), x, z));
    add(model, grid("top", 1, corner + glm::vec3(0, 4.1f, 0), x, z));
    add(model, grid("left", 1, corner + glm::vec3(0.1f, 0, 0), y, z));
    add(model, grid("right", 1, corner + glm::vec3(4.1f, 0, 0), y, z));
    add(model, grid("back", 1, corner + glm::vec3(0, 0, 0.1f), x, y));
    add(model, grid("front", 1, corner + glm::vec3(0, 0, 4.1f), x, y));
    add(model, ball({0, 1.6f, 0}, 0.5f, 8));
    const HeadBoxes boxes(laps(20), 0.13, 8);
    EXPECT_EQ(boxes.centres().size(), 4u);
    for (const glm::dvec3& centre : boxes.centres())
        EXPECT_LT(std::max(std::abs(centre.x), std::abs(centre.z)), 1.9) << "within the pillar";
    const SeenTriangles seen = find_seen(model, Bvh(model), boxes, 1 << 14, 1);
    EXPECT_EQ(std::ranges::count(seen.back(), 1), 0) << "the ball in it";
    for (std::size_t side = 2; side < 6; ++side)
        EXPECT_EQ(std::ranges::count(seen[side], 1), 2);
}

/// The walk begins and ends before a wall; only from beyond it can the column be seen.
TEST(ClientModels, KeepWhatTheMiddleOfALongWalkSees) {
    SceneModel model;
    model.materials.resize(1);
    add(model, grid("floor", 2, {-8, 0, -8}, {16, 0, 0}, {0, 0, 16}));
    add(model, grid("wall", 1, {0, 0, -2.5f}, {0, 0, 5}, {0, 4, 0}));
    for (int i = 0; i < 8; ++i)
        add(model, grid("column", 1, {-1.5f, 0.5f + 0.2f * float(i), -0.2f}, {0, 0, 0.4f}, {0, 0.15f, 0}));
    SceneDescription scene;
    scene.camera_path = laps(191);
    scene.head_radius_m = 0.1;
    const ClientModel built = build_client_model(model, scene,
                                                 {.error_rad = error_rad,
                                                  .silhouette_rad = error_rad / default_budget_share,
                                                  .visibility_rays = 1 << 17,
                                                  .check_rays = 1 << 15});
    EXPECT_TRUE(built.figures.holds);
    std::int64_t of_column = 0;
    for (const Mesh& mesh : built.model.meshes)
        of_column +=
            std::ranges::count_if(mesh.triangles, [&](const glm::uvec3& t) { return mesh.positions[t.x].x == -1.5f; });
    EXPECT_EQ(of_column, 16);
}

/// What touches what is seen is kept with it, and movers whole, whichever of the objects is the scene's first.
TEST(ModelDrafts, KeepWhatTouchesWhatIsSeen) {
    const auto triangle = [](const std::string& name, const glm::vec3& at, const glm::vec3& side) {
        Mesh mesh;
        mesh.name = name;
        mesh.positions = {at, at + side, at + glm::vec3(0, 1, 0)};
        mesh.triangles.emplace_back(0u, 1u, 2u);
        return mesh;
    };
    SceneDescription still;
    still.camera_path = PosePath({PosePath::Key{0, {}}}, "test");
    SceneDescription moving = still;
    moving.moving.push_back({"left", still.camera_path});
    const HeadBoxes boxes(still.camera_path, 0.1);
    const auto kept = [&](const SceneModel& model, const SceneDescription& description, SeenTriangles seen) {
        ModelDraft draft(model, description, boxes, error_rad);
        draft.keep(std::move(seen));
        return draft.kept_triangles();
    };

    SceneModel three;
    three.materials.resize(1);
    add(three, triangle("left", {0, 0, -3}, {-1, 0, 0}));
    add(three, triangle("right", {0, 0, -3}, {1, 0, 0}));
    add(three, triangle("apart", {9, 0, -3}, {1, 0, 0}));
    EXPECT_EQ(kept(three, still, {{1}, {0}, {0}}), 2u);
    EXPECT_EQ(kept(three, still, {{0}, {1}, {0}}), 2u);
    EXPECT_EQ(kept(three, still, {{0}, {0}, {1}}), 1u);
    EXPECT_EQ(kept(three, moving, {{0}, {0}, {0}}), 1u);

    SceneModel placed;
    placed.materials.resize(1);
    add(placed, grid("pair", 1, {0, 0, -3}, {1, 0, 0}, {0, 1, 0}));
    placed.instances.push_back({0, 0, glm::translate(glm::mat4(1), glm::vec3(3, 0, 0))});
    EXPECT_EQ(kept(placed, still, {{1, 0}, {0, 0}}), 2u) << "the other one touches nothing";
    EXPECT_EQ(kept(placed, still, {{0, 0}, {1, 0}}), 2u);
}

TEST_F(ClientModelTest, OptionsOutOfRangeAreOneClearLine) {
    const auto refused = [&] { EXPECT_THROW(build_client_model(model, scene, options), InputError); };
    const ClientModelOptions good = options;
    options.error_rad = 0;
    refused();
    options.error_rad = std::nan("");
    refused();
    options = good;
    options.silhouette_rad = 0.5 * good.error_rad;
    refused();
    options = good;
    scene.head_radius_m = 0;
    options.ipd_m = 0;
    refused();
    options = good;
    scene.camera_path = {};
    refused();
}

}  // namespace
}  // namespace equistream::test
