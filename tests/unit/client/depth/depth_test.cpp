#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/rec709.h>

#include <client/depth/base_textures.h>
#include <client/depth/ray_colour.h>
#include <client/depth/ray_depth.h>
#include <scenes/library/write_glb.h>
#include <tests/support/patch_ray.h>
#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/client/squares.h>
#include <tests/unit/evidence.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;
using glm::dvec3;

/// A square wall of 8 m at z = -3 and before it a square of 1 m that moves to the right at 1 m/s.
class RayDepthTest : public testing::Test {
protected:
    fs::path folder = fs::temp_directory_path() / ("equistream_depth_" + std::to_string(::getpid()));
    SceneDescription scene;

    void SetUp() override {
        SceneModel model;
        model.materials.resize(1);
        add_square(model, "wall", 4, {0, 0, -3}, 0);
        add_square(model, "block", 0.5, {0, 0, -2}, 0);
        fs::create_directories(folder);
        scene.model = folder / "two.glb";
        write_glb(scene.model, model);
        const auto key = [](double time_s, double x) { return PosePath::Key{time_s, {{x, 0, -2}, {1, 0, 0, 0}}}; };
        scene.moving.push_back({"block", PosePath({key(0, 0), key(1, 1)}, "test")});
    }
    void TearDown() override { fs::remove_all(folder); }

    static Distance expected(double block_x) {
        return [block_x](const dvec3& o, const dvec3& d) {
            const double block = to_plane(o, d, {0, 0, 1}, -2);
            const dvec3 b = o + block * d;
            if (std::abs(b.x - block_x) < 0.5 && std::abs(b.y) < 0.5)
                return block;
            const double wall = to_plane(o, d, {0, 0, 1}, -3);
            const dvec3 w = o + wall * d;
            return std::abs(w.x) < 4 && std::abs(w.y) < 4 ? wall : infinity;
        };
    }
};

TEST_F(RayDepthTest, MatchesTheClosedFormWhereverTheBlockIs) {
    RayDepth depth(scene);
    const Pose pose{{0.2, -0.1, 0.3}, yaw_pitch(0.3, 0.1)};
    for (const double time_s : {0.0, 0.7, 0.25}) {
        depth.set_time(time_s);
        for (const Camera& camera : {Camera(EquirectCamera{203, 101, {}}), Camera(PerspectiveCamera{131, 77, 1.4})}) {
            const int width = width_of(camera), height = height_of(camera);
            FloatImage cast(width, height, 1), exact(width, height, 1);
            depth.cast(camera, pose, cast.view());
            AnalyticDepth(expected(time_s)).cast(camera, pose, exact.view());
            int different = 0, misses = 0;
            for (std::size_t i = 0; i < cast.samples().size(); ++i) {
                const float a = cast.samples()[i], b = exact.samples()[i];
                misses += std::isinf(b);
                different += !(a == b || std::abs(a - b) < 2e-5f * b);
            }
            EXPECT_LE(different, 2) << "pixel centres on an edge may fall either way"
                                    << evidence(cast.view(), exact.view());
            EXPECT_GT(misses, 0);
        }
    }
}

TEST_F(RayDepthTest, PatchesAreCastFromTheirOwnOrigins) {
    PatchAtlas atlas;
    atlas.sphere_width = 203;
    atlas.sphere_height = 101;
    atlas.offsets_m = {{0.2, 0, 0}, {-0.1, 0.15, 0.05}};
    atlas.columns = 7;
    for (const int side : {4, 6, 16}) {
        atlas.block_side = side;
        atlas.slots.clear();
        // Every block, those beyond the sphere's right and lower border too, then one that nobody uses.
        for (int y = 0; y < atlas.block_rows(); ++y)
            for (int x = 0; x < atlas.block_columns(); ++x)
                atlas.slots.push_back({std::uint8_t((x + y) % 2), std::uint16_t(x), std::uint16_t(y), true});
        do
            atlas.slots.push_back({});
        while (atlas.slots.size() % 7 != 0);
        atlas.rows = int(atlas.slots.size()) / 7;
        ASSERT_FALSE(patch_atlas_problem(atlas));
        const Pose pose{{0.2, -0.1, 0.3}, yaw_pitch(0.3, 0.1)};
        FloatImage cast(atlas.width(), atlas.height(), 1, -1);
        ExactDepth depth(std::make_unique<RayDepth>(scene));
        depth.set_time(0.25);
        ASSERT_TRUE(depth.cast_patches(atlas, pose, cast.view()));
        int different = 0, hits = 0, unused = 0;
        for (int y = 0; y < cast.height(); ++y)
            for (int x = 0; x < cast.width(); ++x) {
                const float found = *cast.pixel(x, y);
                if (!atlas.slot_at(x, y).used) {
                    unused += found == std::numeric_limits<float>::infinity();
                    continue;
                }
                const PatchRay ray = patch_ray(atlas, x, y, x + 0.5, y + 0.5);
                const double exact =
                    expected(0.25)(pose.position_m + pose.orientation * ray.origin_m, pose.orientation * ray.direction);
                hits += std::isfinite(exact);
                different += !(found == float(exact) || std::abs(found - exact) < 2e-5 * exact);
            }
        EXPECT_LE(different, 3) << "pixel centres on an edge may fall either way";
        EXPECT_GT(hits, 1000);
        EXPECT_GE(unused, side * side);
    }
    FloatImage none(4, 4, 1, -1);
    EXPECT_FALSE(ExactDepth().cast_patches(atlas, Pose{}, none.view()));
    EXPECT_EQ(*none.pixel(0, 0), -1);
}

TEST_F(RayDepthTest, ExactPlanesGoToTheirOwnViewOnly) {
    const Camera camera = PerspectiveCamera{4, 3, 1};
    const Pose pose{{1, 2, 3}, yaw_pitch(0.1, 0)};
    FloatImage out(4, 3, 1);
    ExactDepth alone;
    EXPECT_THROW(alone.cast(camera, pose, out.view()), WorkError);
    const FloatImage seven(4, 3, 1, 7.0f);
    alone.add(camera, pose, seven.view());
    alone.cast(camera, pose, out.view());
    EXPECT_EQ(out.pixel(3, 2)[0], 7.0f);
    EXPECT_THROW(alone.cast(camera, Pose{}, out.view()), WorkError);
    alone.set_time(1);
    EXPECT_THROW(alone.cast(camera, pose, out.view()), WorkError);

    ExactDepth with_ray(std::make_unique<RayDepth>(scene));
    with_ray.cast(camera, Pose{}, out.view());
    EXPECT_NEAR(out.pixel(1, 1)[0], 2, 0.2);
}

TEST_F(RayDepthTest, AMissingModelIsOneClearLine) {
    scene.model = folder / "none.glb";
    EXPECT_THROW(RayDepth depth(scene), InputError);
}

}  // namespace

namespace {

namespace fs = std::filesystem;

/// At z = -3 a wall of 4 m whose texture is a ramp, before it a lamp and a mirror, and a block that moves to the right
/// at 1 m/s.
class RayColourTest : public testing::Test {
protected:
    static constexpr int texels = 64;
    fs::path folder = fs::temp_directory_path() / ("equistream_colour_" + std::to_string(::getpid()));
    SceneDescription scene;

    void SetUp() override {
        fs::create_directories(folder);
        ByteImage ramp(texels, texels, 3);
        for (int y = 0; y < texels; ++y)
            for (int x = 0; x < texels; ++x) {
                const std::uint8_t colour[] = {std::uint8_t(4 * x), std::uint8_t(4 * y), 90};
                std::copy_n(colour, 3, ramp.pixel(x, y));
            }
        write_picture(folder / "ramp.png", ramp.view());
        std::ifstream file(folder / "ramp.png", std::ios::binary);
        SceneModel model;
        model.textures.push_back({.name = "ramp",
                                  .mime_type = "image/png",
                                  .encoded{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()},
                                  .wrap_u = Wrap::clamp,
                                  .wrap_v = Wrap::clamp});
        model.materials.resize(4);
        for (Material& material : model.materials)
            material.metallic = 0;
        model.materials[0].base_colour = {0.5f, 1, 1};
        model.materials[0].base_colour_texture = 0;
        model.materials[1].emission = {5, 5, 5};
        model.materials[2].metallic = 1;
        model.materials[2].roughness = 0;
        model.materials[3].base_colour = {0.1f, 0.2f, 0.3f};
        add_square(model, "wall", 2, {0, 0, -3}, std::uint32_t(model.meshes.size()));
        add_square(model, "lamp", 0.2f, {-1, 1, -2.5}, std::uint32_t(model.meshes.size()));
        add_square(model, "mirror", 0.2f, {1, 1, -2.5}, std::uint32_t(model.meshes.size()));
        add_square(model, "block", 0.2f, {0, 0, -2}, std::uint32_t(model.meshes.size()));
        scene.model = folder / "four.glb";
        write_glb(scene.model, model);
        const auto key = [](double time_s, double x) { return PosePath::Key{time_s, {{x, 0, -2}, {1, 0, 0, 0}}}; };
        scene.moving.push_back({"block", PosePath({key(0, 0), key(1, 1)}, "test")});
    }
    void TearDown() override { fs::remove_all(folder); }

    static GeometryHit cast(RayColour& geometry, const glm::vec3& to, float spread_rad = 0) {
        const GeometryRay ray{glm::vec3(0), glm::normalize(to), spread_rad};
        GeometryHit hit;
        geometry.cast({&ray, 1}, {&hit, 1});
        return hit;
    }
};

TEST_F(RayColourTest, ColoursAreThoseOfTheTextureWhereTheRayHits) {
    RayColour geometry(scene);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> anywhere(-1.9f, 1.9f);
    std::vector<GeometryRay> rays;
    for (int i = 0; i < 37; ++i)
        rays.push_back(
            {glm::vec3(0), glm::normalize(glm::vec3(anywhere(random), -std::abs(anywhere(random)) - 0.4f, -3))});
    std::vector<GeometryHit> hits(rays.size());
    geometry.cast(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const glm::vec3 p = rays[i].direction * hits[i].distance_m;
        if (p.y < -1.95)  // beside the wall, or beyond the middle of its last texels
            continue;
        EXPECT_NEAR(p.z, -3, 1e-5);
        EXPECT_EQ(hits[i].normal, glm::vec3(0, 0, 1));
        EXPECT_TRUE(hits[i].matte);
        // The ramp is linear in sRGB, and bilinear in linear light between two of its steps.
        const auto ramp = [](float t) { return srgb_to_linear((4 * (t * texels - 0.5f)) / 255); };
        EXPECT_NEAR(hits[i].base_colour.r, 0.5f * ramp((p.x + 2) / 4), 2e-3);
        EXPECT_NEAR(hits[i].base_colour.g, ramp((2 - p.y) / 4), 2e-3);
        EXPECT_NEAR(hits[i].base_colour.b, srgb_to_linear(90.0f / 255), 1e-6);
    }
}

TEST_F(RayColourTest, LoadedInTheBackgroundIsTheSame) {
    RayColour early(scene), late(scene);
    early.start_loading();
    for (const glm::vec3 to : {glm::vec3(0.3f, 0.4f, -3), {-1, 1, -2.5f}, {0, 0, -2}, {0, 3, 0}}) {
        const GeometryHit a = cast(early, to), b = cast(late, to);
        EXPECT_EQ(a.distance_m, b.distance_m);
        EXPECT_EQ(a.base_colour, b.base_colour);
        EXPECT_EQ(a.matte, b.matte);
    }
}

TEST_F(RayColourTest, WhatFailsInTheBackgroundIsThrownByTheFirstCast) {
    scene.model = folder / "none.glb";
    RayColour geometry(scene);
    geometry.start_loading();
    EXPECT_THROW(cast(geometry, {0, 0, -3}), InputError);
}

TEST_F(RayColourTest, CoordinatesBeyondATextureGoOnAsItSays) {
    constexpr std::array<std::uint8_t, 4> grey = {10, 60, 120, 200};
    ByteImage row(4, 1, 3);
    for (int x = 0; x < 4; ++x)
        std::fill_n(row.pixel(x, 0), 3, grey[std::size_t(x)]);
    write_picture(folder / "row.png", row.view());
    SceneModel model;
    for (const Wrap wrap : {Wrap::repeat, Wrap::clamp, Wrap::mirror}) {
        std::ifstream file(folder / "row.png", std::ios::binary);
        model.textures.push_back({.name = "row",
                                  .mime_type = "image/png",
                                  .encoded{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()},
                                  .wrap_u = wrap,
                                  .wrap_v = wrap});
    }
    const BaseTextures textures(model);
    for (int i = -9; i <= 9; ++i) {
        const int period = ((i % 8) + 8) % 8;
        const std::array at = {period % 4, std::clamp(i, 0, 3), period < 4 ? period : 7 - period};
        for (std::uint32_t texture = 0; texture < 3; ++texture) {
            const float expected = srgb_to_linear(float(grey[std::size_t(at[texture])]) / 255);
            EXPECT_NEAR(textures.lookup(texture, {(float(i) + 0.5f) / 4, 0.5f}, 0).r, expected, 1e-5)
                << texture << ' ' << i;
        }
    }
}

TEST_F(RayColourTest, GlassIsNotMatteAndRoughMetalIs) {
    Material glass, metal;
    glass.metallic = 0;
    glass.transmission = 1;
    EXPECT_FALSE(is_matte(glass));
    metal.metallic = metal.roughness = 1;
    EXPECT_TRUE(is_matte(metal));
}

TEST_F(RayColourTest, AWideRaySeesTheMean) {
    RayColour geometry(scene);
    const GeometryHit hit = cast(geometry, {0.5f, -1, -3}, 4);
    float mean = 0;
    for (int x = 0; x < texels; ++x)
        mean += srgb_to_linear(float(4 * x) / 255) / texels;
    EXPECT_NEAR(hit.base_colour.r, 0.5f * mean, 0.01);
}

TEST_F(RayColourTest, FarOffAFineCheckerIsAsBrightAsItsLight) {
    ByteImage checker(8, 8, 3);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
            std::fill_n(checker.pixel(x, y), 3, std::uint8_t((x + y) % 2 == 0 ? 0 : 255));
    write_picture(folder / "checker.png", checker.view());
    std::ifstream file(folder / "checker.png", std::ios::binary);
    SceneModel model;
    model.textures.push_back({.name = "checker",
                              .mime_type = "image/png",
                              .encoded{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()},
                              .wrap_u = Wrap::repeat,
                              .wrap_v = Wrap::repeat});
    const BaseTextures textures(model);
    for (const float footprint : {0.25f, 1.0f})
        EXPECT_NEAR(textures.lookup(0, {0.3f, 0.6f}, footprint).r, 0.5f, 0.004f) << footprint;
}

/// The wall's 64 texels lie 1/16 m apart: across two of them a ray sees their mean, across less than one a point.
TEST_F(RayColourTest, ARayIsAsWideOnTheTextureAsOnTheWall) {
    RayColour geometry(scene);
    const float distance_m = glm::length(glm::vec3(0.5f, -1, -3)), cosine = 3 / distance_m;
    const auto red = [&](float texels_wide) {
        const float width_m = texels_wide / 16 * std::sqrt(cosine);
        return cast(geometry, {0.5f, -1, -3}, width_m / distance_m).base_colour.r;
    };
    EXPECT_EQ(red(0.9f), red(0));
    EXPECT_NE(red(2), red(0));
    EXPECT_NEAR(red(2), red(0), 2e-3) << "the ramp's mean about that point is nearly its colour there";
}

TEST_F(RayColourTest, LampsAndMirrorsAreNotMatte) {
    RayColour geometry(scene);
    EXPECT_FALSE(cast(geometry, {-1, 1, -2.5}).matte);
    EXPECT_FALSE(cast(geometry, {1, 1, -2.5}).matte);
    EXPECT_TRUE(cast(geometry, {1, -1, -3}).matte);
    EXPECT_NE(cast(geometry, {-1, 1, -2.5}).instance, cast(geometry, {1, 1, -2.5}).instance);
}

TEST_F(RayColourTest, ObjectsAreWhereTheyAreAtTheTime) {
    RayColour geometry(scene);
    const glm::vec3 block(0.1f, 0.2f, 0.3f);
    EXPECT_EQ(cast(geometry, {0, 0, -1}).base_colour, block);
    geometry.set_time(0.5);
    EXPECT_FLOAT_EQ(cast(geometry, {0, 0, -1}).distance_m, 3);
    EXPECT_EQ(cast(geometry, {0.5f, 0, -2}).base_colour, block);
    EXPECT_TRUE(std::isinf(cast(geometry, {0, 0, 1}).distance_m));
}

}  // namespace
}  // namespace equistream::test
