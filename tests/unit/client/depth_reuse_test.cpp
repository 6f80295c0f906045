#include "evidence.h"
#include "scratch_folder.h"

#include <equistream/depth_agreement.h>
#include <equistream_client/ray_depth.h>
#include <equistream_generate/generate.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace equistream::test {
namespace {

constexpr EquirectCamera sphere{768, 384, {}};

struct Disagreement {
    double beyond = 0;       ///< part of the pixels that are off by more than the bound
    double not_at_edge = 0;  ///< of them, those that the pixel's eight neighbours do not bracket
};

/// Every pixel of `carried` against a full cast, in w.
Disagreement compare(const FloatImage& carried, const FloatImage& cast, double box_m, double error) {
    const auto w = [&](const FloatImage& image, int x, int y) {
        return bounded_inverse_depth(
            double(image.pixel((x + sphere.width) % sphere.width, std::clamp(y, 0, sphere.height - 1))[0]), box_m);
    };
    std::int64_t beyond = 0, inner = 0;
    for (int y = 0; y < sphere.height; ++y)
        for (int x = 0; x < sphere.width; ++x) {
            const double here = w(carried, x, y);
            if (std::abs(here - w(cast, x, y)) <= error)
                continue;
            ++beyond;
            double low = w(cast, x, y), high = low;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    low = std::min(low, w(cast, x + dx, y + dy));
                    high = std::max(high, w(cast, x + dx, y + dy));
                }
            inner += !(here >= low - error && here <= high + error);
        }
    const double pixels = double(sphere.width) * sphere.height;
    return {double(beyond) / pixels, double(inner) / pixels};
}

/// Part of the pixels that lie beside an edge: one surface ends there, so that no slope explains the step.
double part_at_edges(const FloatImage& cast, double box_m, double error) {
    const DepthAgreement bound{float(box_m), float(std::sin(error))};
    const auto inverse = [&](int x, int y) {
        const int column = (x + sphere.width) % sphere.width, row = std::clamp(y, 0, sphere.height - 1);
        return 1 / std::min(cast.pixel(column, row)[0], far_distance_m);
    };
    std::int64_t edges = 0;
    for (int y = 0; y < sphere.height; ++y)
        for (int x = 0; x < sphere.width; ++x) {
            bool edge = false;
            for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
                edge |= !bound.connected(inverse(x - dx, y - dy), inverse(x, y), inverse(x + dx, y + dy),
                                         inverse(x + 2 * dx, y + 2 * dy));
            edges += edge;
        }
    return double(edges) / (double(sphere.width) * sphere.height);
}

/// What a count of pixels that fall to one side of an edge or to the other may become where only roundings change: four
/// standard deviations more.
double part_of(int counted) {
    return (counted + 4 * std::sqrt(double(counted))) / (double(sphere.width) * sphere.height);
}
/// What is thinner than a pixel is seen by one cast and missed by the next, and nothing around it tells: 31 pixels in
/// the worst frame of all these walks.
const double most_not_at_edge = part_of(31);

class DepthReuseTest : public testing::TestWithParam<const char*> {};

/// A walk of the scene's own; each frame is carried on from frames that were carried themselves.
TEST_P(DepthReuseTest, StaysWithinTheBoundAlongAWalkButAtEdges) {
    const ScratchFolder folder("depth-reuse");
    const SceneDescription scene = load_scene(write_scene(make_scene(find_generator(GetParam())), folder.path()));
    RayDepth plain(scene), carrying(scene, {.reuse = true});
    const double box_m = head_box_radius_centre(scene.lean_m, default_ipd_m), error = RayDepthOptions{}.error_rad;
    FloatImage cast(sphere.width, sphere.height, 1), carried(sphere.width, sphere.height, 1);
    for (int frame = 0; frame < 12; ++frame) {
        const double time_s = frame / 30.0;
        const Pose pose{scene.camera_path.at(time_s).position_m, {1, 0, 0, 0}};
        plain.set_time(time_s);
        carrying.set_time(time_s);
        plain.cast(sphere, pose, cast.view());
        carrying.cast(sphere, pose, carried.view());
        const Disagreement off = compare(carried, cast, box_m, error);
        EXPECT_LE(off.not_at_edge, most_not_at_edge) << "frame " << frame << evidence(carried.view(), cast.view());
        if (frame == 0) {
            EXPECT_EQ(off.beyond, 0);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, DepthReuseTest, testing::Values("pavilion", "motion"));

/// The last tiles of a row may be narrower than the others: the seam closes by pixels.
TEST(DepthReuse, AnyWidthClosesAtTheSeam) {
    const ScratchFolder folder("depth-reuse");
    const SceneDescription scene = load_scene(write_scene(make_scene(find_generator("pavilion")), folder.path()));
    RayDepth plain(scene);
    const double box_m = head_box_radius_centre(scene.lean_m, default_ipd_m), error = RayDepthOptions{}.error_rad;
    // Part of the pixels next to the seam that are beyond the bound.
    const auto beyond_at_seam = [&](const EquirectCamera& camera) {
        RayDepth carrying(scene, {.reuse = true});
        FloatImage cast(camera.width, camera.height, 1), carried(camera.width, camera.height, 1);
        std::int64_t beyond = 0, pixels = 0;
        for (int frame = 0; frame < 8; ++frame) {
            const Pose pose{scene.camera_path.at(0).position_m + double(frame) * glm::dvec3(0.03, 0, -0.04),
                            {1, 0, 0, 0}};
            plain.cast(camera, pose, cast.view());
            carrying.cast(camera, pose, carried.view());
            for (int y = 0; y < camera.height; ++y)
                for (int i = -16; i < 16; ++i, ++pixels) {
                    const int x = (i + camera.width) % camera.width;
                    beyond += std::abs(bounded_inverse_depth(double(carried.pixel(x, y)[0]), box_m) -
                                       bounded_inverse_depth(double(cast.pixel(x, y)[0]), box_m)) > error;
                }
        }
        return double(beyond) / double(pixels);
    };
    const double whole_tiles = beyond_at_seam({640, 320, {}});
    for (const int width : {634, 642, 650})
        EXPECT_LE(beyond_at_seam({width, width / 2, {}}), 1.2 * whole_tiles) << width;
}

struct Walk {
    const char* scene;
    glm::dvec3 step_m;  ///< a frame
    int counted;        ///< pixels beyond the bound in the walk's worst frame
};

/// An edge is found to the nearest pixel, at most half of one off: of the pixels whose middles it may pass, one in two.
/// Those are two of three where edges are as near each other as may be, a bar one pixel wide and what is on either
/// side.
constexpr double most_of_edges = 1 / 3.0;

class DepthReuseWalk : public testing::TestWithParam<Walk> {};

/// Where a surface was seen, its plane is met again exactly: a pixel beyond the bound shows another surface than a
/// fresh cast. That is left to edges, by a pixel, and does not gather; thin bars that come nearer are seen as they do.
TEST_P(DepthReuseWalk, SeesTheSurfacesThatACastSees) {
    const ScratchFolder folder("depth-reuse");
    const SceneDescription scene = load_scene(write_scene(make_scene(find_generator(GetParam().scene)), folder.path()));
    RayDepth plain(scene), carrying(scene, {.reuse = true});
    const double box_m = head_box_radius_centre(scene.lean_m, default_ipd_m), error = RayDepthOptions{}.error_rad;
    FloatImage cast(sphere.width, sphere.height, 1), carried(sphere.width, sphere.height, 1);
    for (int frame = 0; frame < 14; ++frame) {
        const Pose pose{scene.camera_path.at(0).position_m + double(frame) * GetParam().step_m, {1, 0, 0, 0}};
        plain.cast(sphere, pose, cast.view());
        carrying.cast(sphere, pose, carried.view());
        const Disagreement off = compare(carried, cast, box_m, error);
        EXPECT_LE(off.beyond, part_of(GetParam().counted))
            << "frame " << frame << evidence(carried.view(), cast.view());
        EXPECT_LE(off.beyond, most_of_edges * part_at_edges(cast, box_m, error)) << "frame " << frame;
        EXPECT_LE(off.not_at_edge, most_not_at_edge) << "frame " << frame;
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, DepthReuseWalk,
                         testing::Values(Walk{"pavilion", {0.03, 0, -0.04}, 2304}, Walk{"wires", {0.05, 0, 0}, 513},
                                         Walk{"wires", {0, 0, -0.05}, 1353}),
                         [](const auto& walk) { return walk.param.scene + std::to_string(walk.index); });

TEST(DepthReuse, EyesOfOneHeadEachKeepTheirOwn) {
    const ScratchFolder folder("depth-reuse");
    const SceneDescription scene = load_scene(write_scene(make_scene(find_generator("pavilion")), folder.path()));
    RayDepth plain(scene), carrying(scene, {.reuse = true});
    const double box_m = head_box_radius_centre(scene.lean_m, default_ipd_m), error = RayDepthOptions{}.error_rad;
    FloatImage cast(sphere.width, sphere.height, 1), carried(sphere.width, sphere.height, 1);
    for (int frame = 0; frame < 4; ++frame)
        for (const Eye eye : {Eye::left, Eye::right}) {
            const Pose pose{eye_position(scene.camera_path.at(frame / 30.0), eye, default_ipd_m), {1, 0, 0, 0}};
            plain.cast(sphere, pose, cast.view());
            carrying.cast(sphere, pose, carried.view());
            EXPECT_LE(compare(carried, cast, box_m, error).not_at_edge, most_not_at_edge) << "frame " << frame;
        }
    // Standing still, only what is cast anew may change, and a leap is cast.
    const Pose leap{glm::dvec3(0, 1.5, 0) + scene.camera_path.at(0).position_m, {1, 0, 0, 0}};
    plain.cast(sphere, leap, cast.view());
    carrying.cast(sphere, leap, carried.view());
    EXPECT_LE(compare(carried, cast, box_m, error).not_at_edge, most_not_at_edge);
}

}  // namespace
}  // namespace equistream::test
