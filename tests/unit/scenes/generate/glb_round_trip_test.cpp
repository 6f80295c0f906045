#include "scratch_folder.h"

#include <equistream/error.h>

#include <programs/scene/summary.h>
#include <scenes/generate/generate.h>
#include <scenes/generate/scene_builder.h>
#include <scenes/library/polygon.h>
#include <scenes/library/write_glb.h>

#include <gtest/gtest.h>

#include <fstream>

namespace equistream::generate {
namespace {

/// One of everything the writer knows.
SceneModel sample_model() {
    SceneBuilder scene;
    const auto holes = paint(16, 8, 4, [](glm::vec2 at) { return glm::vec4(at, 0.5f, at.x > 0.5f ? 1.0f : 0.2f); });
    const auto leaf = scene.masked_material("leaf", holes, 0.6f);
    Material everything =
        textured("everything",
                 scene.texture("checks", paint(8, 8, 3, [](glm::vec2 at) { return glm::vec4(at, 0.25f, 1); }),
                               Encoding::png, Wrap::mirror),
                 0.35f);
    everything.base_colour = {0.1f, 0.7f, 0.3f};
    everything.metallic = 0.25f;
    everything.metallic_roughness_texture = everything.emission_texture = everything.base_colour_texture;
    everything.emission = {8, 2, 0.5f};
    everything.transmission = 0.75f;
    everything.index_of_refraction = 1.33f;
    everything.double_sided = true;
    const auto stuff = scene.material(everything);
    const auto ball = scene.mesh("ball", sphere(1, 24, 12), stuff);
    const auto card_mesh = scene.mesh("card", card(2, 1), leaf);
    scene.object("one", {ball, card_mesh}, moved({1, 2, 3}));
    scene.object("two", {ball, card_mesh}, turned_y(0.7f) * glm::scale(glm::mat4(1), glm::vec3(2, 1, -1)));
    scene.object("three", {ball});
    scene.object("empty", {});
    return scene.finish();
}

class GlbRoundTrip : public testing::Test {
protected:
    SceneModel read_back(const SceneModel& model) {
        write_glb(folder_ / "model.glb", model);
        return load_model(folder_ / "model.glb");
    }
    ScratchFolder folder_{"glb"};
};

TEST_F(GlbRoundTrip, GeometryAndPlacementsComeBackExactly) {
    const SceneModel out = sample_model(), in = read_back(out);
    ASSERT_EQ(in.instances.size(), out.instances.size());
    ASSERT_EQ(in.objects.size(), out.objects.size());
    for (std::size_t i = 0; i < out.objects.size(); ++i)
        EXPECT_EQ(in.objects[i].name, out.objects[i].name);
    for (std::size_t i = 0; i < out.instances.size(); ++i) {
        EXPECT_EQ(in.instances[i].object, out.instances[i].object);
        EXPECT_EQ(in.instances[i].world_from_object, out.instances[i].world_from_object);
        const Mesh& a = in.meshes[in.instances[i].mesh];
        const Mesh& b = out.meshes[out.instances[i].mesh];
        EXPECT_TRUE(a.positions == b.positions);
        EXPECT_TRUE(a.uvs == b.uvs);
        EXPECT_TRUE(a.triangles == b.triangles);
        ASSERT_EQ(a.normals.size(), b.normals.size());
        for (std::size_t k = 0; k < a.normals.size(); ++k)  // the reader makes them unit once more
            EXPECT_LT(glm::length(a.normals[k] - b.normals[k]), 1e-6f);
        EXPECT_EQ(a.material, b.material);
    }
}

TEST_F(GlbRoundTrip, PlacementsOfTheSameMeshesShareThem) {
    const SceneModel in = read_back(sample_model());
    EXPECT_EQ(in.unique_triangle_count(), 2 * 24 * 11 + 2 + 2 * 24 * 11);  // {ball, card} twice; {ball} alone
    EXPECT_EQ(in.instances[0].mesh, in.instances[2].mesh);
    EXPECT_EQ(in.instances[1].mesh, in.instances[3].mesh);
}

TEST_F(GlbRoundTrip, MaterialsTexturesAndMasksComeBackExactly) {
    const SceneModel out = sample_model(), in = read_back(out);
    ASSERT_GE(in.materials.size(), out.materials.size());
    for (std::size_t i = 0; i < out.materials.size(); ++i) {
        const Material &a = in.materials[i], &b = out.materials[i];
        EXPECT_EQ(a.name, b.name);
        EXPECT_EQ(a.base_colour, b.base_colour);
        EXPECT_EQ(a.base_colour_texture, b.base_colour_texture);
        EXPECT_EQ(a.metallic, b.metallic);
        EXPECT_EQ(a.roughness, b.roughness);
        EXPECT_EQ(a.metallic_roughness_texture, b.metallic_roughness_texture);
        EXPECT_EQ(a.emission, b.emission);
        EXPECT_EQ(a.emission_texture, b.emission_texture);
        EXPECT_EQ(a.transmission, b.transmission);
        EXPECT_EQ(a.index_of_refraction, b.index_of_refraction);
        EXPECT_EQ(a.double_sided, b.double_sided);
        EXPECT_EQ(a.alpha_mask, b.alpha_mask);
    }
    ASSERT_EQ(in.textures.size(), out.textures.size());
    for (std::size_t i = 0; i < out.textures.size(); ++i) {
        EXPECT_EQ(in.textures[i].encoded, out.textures[i].encoded);
        EXPECT_EQ(in.textures[i].mime_type, out.textures[i].mime_type);
        EXPECT_EQ(in.textures[i].wrap_u, out.textures[i].wrap_u);
        EXPECT_EQ(in.textures[i].wrap_v, out.textures[i].wrap_v);
    }
    ASSERT_EQ(in.alpha_masks.size(), 1u);
    EXPECT_EQ(in.alpha_masks[0].width, 16);
    EXPECT_EQ(in.alpha_masks[0].height, 8);
    EXPECT_EQ(in.alpha_masks[0].opaque, out.alpha_masks[0].opaque);
    EXPECT_TRUE(in.alpha_masks[0].covers({0.75f, 0.5f}));
    EXPECT_FALSE(in.alpha_masks[0].covers({0.25f, 0.5f}));
}

TEST_F(GlbRoundTrip, MoreThan65535VerticesKeepTheirIndices) {
    SceneBuilder scene;
    scene.add("big", sphere(1, 400, 200), scene.material(matt("grey", glm::vec3(0.5f))));
    const SceneModel out = scene.finish(), in = read_back(out);
    EXPECT_TRUE(in.meshes[0].triangles == out.meshes[0].triangles);
}

TEST_F(GlbRoundTrip, ParentsKeepTheirChildrenInPlace) {
    SceneModel out = sample_model();
    out.objects[1].parent = 0;
    const SceneModel in = read_back(out);
    ASSERT_EQ(in.objects.size(), out.objects.size());
    for (std::size_t i = 0; i < out.objects.size(); ++i)
        EXPECT_EQ(in.objects[i].parent, out.objects[i].parent) << i;
    int compared = 0;
    for (const Instance& instance : in.instances) {
        if (in.objects[instance.object].name != "two")
            continue;
        ++compared;
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 4; ++r)
                EXPECT_NEAR(instance.world_from_object[c][r], out.instances[2].world_from_object[c][r], 1e-5f);
    }
    EXPECT_EQ(compared, 2) << "its ball and its card";
}

/// OBJ files and old exporters have names in any coding; JSON has UTF-8.
TEST_F(GlbRoundTrip, NamesOfOtherCodingsAreWritten) {
    SceneModel model = sample_model();
    const std::string latin = "Bl\xe4tter", expected = "Bl\xef\xbf\xbdtter";
    model.materials[0].name = model.meshes[0].name = model.textures[0].name = model.objects[0].name = latin;
    const SceneModel again = read_back(model);
    EXPECT_EQ(again.materials[0].name, expected);
    EXPECT_EQ(again.objects[0].name, expected);
}

TEST_F(GlbRoundTrip, AFileThatCannotBeWrittenIsNamed) {
    const auto file = folder_ / "no-such-folder" / "model.glb";
    try {
        write_glb(file, sample_model());
        FAIL() << "written into a folder that does not exist";
    } catch (const WorkError& error) {
        EXPECT_NE(std::string(error.what()).find("model.glb"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace equistream::generate

namespace equistream {
namespace {

TEST(DistanceToTriangle, FacesEdgesCornersAndSlivers) {
    const glm::dvec3 a(0, 0, 0), b(4, 0, 0), c(0, 3, 0);
    EXPECT_NEAR(distance_to_triangle({1, 1, 2}, a, b, c), 2, 1e-12);
    EXPECT_NEAR(distance_to_triangle({1, 1, -2}, a, b, c), 2, 1e-12);
    EXPECT_NEAR(distance_to_triangle({2, -3, 4}, a, b, c), 5, 1e-12);
    EXPECT_NEAR(distance_to_triangle({-3, -4, 12}, a, b, c), 13, 1e-12);
    EXPECT_NEAR(distance_to_triangle({4, 3, 0}, a, b, c), 12.0 / 5, 1e-12);
    EXPECT_NEAR(distance_to_triangle({2, 1, 0}, a, b, b), 1, 1e-12);
    EXPECT_NEAR(distance_to_triangle({0, 3, 4}, a, a, a), 5, 1e-12);
}

SceneSummary summary_of(const std::string& name, const std::vector<std::string>& options = {}) {
    const GeneratedScene scene = make_scene(find_generator(name), options);
    return summarise(scene.model, scene.description);
}

TEST(Summary, SphereFromInside) {
    const SceneSummary centred = summary_of("sphere", {"radius=2", "n=128"});
    EXPECT_NEAR(centred.nearest_m, 2, 2 * (1 - std::cos(3.15 / 128)));
    EXPECT_EQ(centred.path_length_m, 0);
    const SceneSummary aside = summary_of("sphere", {"radius=2", "n=128", "offset=0.5"});
    EXPECT_NEAR(aside.nearest_m, 1, 2 * (1 - std::cos(3.15 / 128)));
    EXPECT_NEAR(aside.box_high_m.y, 2, 1e-6);
    EXPECT_EQ(aside.emissive_triangles, aside.triangles);
}

TEST(Summary, BoxOfATurnedMeshIsItsOwn) {
    generate::SceneBuilder scene;
    const auto ball = scene.mesh("ball", generate::sphere(1, 64, 32), scene.material({}));
    scene.object("turned", {ball}, generate::turned_y(0.7f));
    SceneDescription description;
    description.camera_path = PosePath({{0, {{0, 0, 5}, {1, 0, 0, 0}}}}, "here");
    const SceneSummary turned = summarise(scene.finish(), description);
    EXPECT_NEAR(turned.box_high_m.x, 1, 2 * (1 - std::cos(3.15 / 64)));  // the turned box of the ball reaches 1.41
    EXPECT_NEAR(turned.box_low_m.z, -1, 2 * (1 - std::cos(3.15 / 64)));
}

/// Frames begin at 0: what a path does before that nobody sees.
TEST(Summary, APathBeginsAtZero) {
    generate::SceneBuilder scene;
    scene.object("ball", {scene.mesh("ball", generate::sphere(1, 16, 8), scene.material({}))});
    const glm::dquat half_right = glm::angleAxis(-1.0, glm::dvec3(0, 1, 0));
    SceneDescription description;
    description.camera_path = PosePath(
        {{-1, {{0, 0, 5}, {1, 0, 0, 0}}}, {1, {{2, 0, 5}, {1, 0, 0, 0}}}, {2, {{2, 0, 8}, half_right}}}, "here");
    const SceneSummary seen = summarise(scene.finish(), description);
    EXPECT_NEAR(seen.path_length_m, glm::length(description.camera_path.at(0).position_m - glm::dvec3(2, 0, 5)) + 3,
                1e-9);
    EXPECT_LT(seen.path_length_m, 4.5);
    EXPECT_NEAR(seen.fastest_turn_deg_s, glm::degrees(1.0), 1e-6);
}

TEST(Summary, BoundOfARoom) {
    // Nearest wall 2.2 m away, eyes within 31.5 mm: w = 0.0315 / 2.1685, in steps of 2 / (4 * 960).
    const SceneSummary room = summary_of("orientation");
    EXPECT_NEAR(room.nearest_m, 2.2, 1e-6);
    EXPECT_NEAR(room.box_radius_m, 0.0315, 1e-12);
    EXPECT_EQ(room.depth_levels, 28);
    EXPECT_EQ(room.unique_triangles, 12u);
}

TEST(Summary, PathOfTheMotionRoom) {
    const SceneSummary room = summary_of("motion");
    EXPECT_NEAR(room.path_length_m, std::sqrt(0.49 + 0.0225 + 0.25), 1e-9);
    EXPECT_NEAR(room.path_duration_s, 1, 1e-12);
    EXPECT_NEAR(room.turn_deg, glm::degrees(0.6), 0.5);
    EXPECT_GE(room.fastest_turn_deg_s, room.turn_deg / room.path_duration_s - 1e-9);
    EXPECT_NEAR(0.75 * room.window_width_deg, 90 + 2 * room.fastest_turn_deg_s * window_delay_s, 1e-9);
    EXPECT_NEAR(0.75 * room.window_height_deg, 58.72 + 2 * room.fastest_turn_deg_s * window_delay_s, 0.01);
    EXPECT_EQ(room.moving_objects, 2u);
}

TEST(GlbSize, WhatItsLengthsCannotSayIsRefused) {
    EXPECT_NO_THROW(require_glb_size(0xffffffff));
    EXPECT_THROW(require_glb_size(std::uint64_t{1} << 32), WorkError);
}

}  // namespace
}  // namespace equistream
