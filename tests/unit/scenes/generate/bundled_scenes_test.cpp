#include "scratch_folder.h"

#include <equistream/error.h>

#include <scenes/generate/generate.h>
#include <scenes/generate/paint.h>
#include <scenes/generate/shapes.h>
#include <scenes/library/write_glb.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

namespace equistream {
namespace {

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

GeneratedScene made(const std::string& name, const std::vector<std::string>& options = {}) {
    return make_scene(find_generator(name), options);
}

/// Made once: it takes a while.
const GeneratedScene& pavilion() {
    static const GeneratedScene scene = made("pavilion");
    return scene;
}

class BundledScene : public testing::TestWithParam<std::string> {};

TEST_P(BundledScene, IsTheSameTwiceAndLoadsAsItWasMade) {
    const ScratchFolder folder("bundled-" + GetParam());
    const GeneratedScene first = GetParam() == "pavilion" ? pavilion() : made(GetParam());
    const auto description = write_scene(first, folder / "a");
    write_scene(made(GetParam()), folder / "b");
    for (const std::string extension : {".glb", ".json"})
        EXPECT_EQ(bytes_of(folder / "a" / (GetParam() + extension)), bytes_of(folder / "b" / (GetParam() + extension)));

    const SceneDescription scene = load_scene(description);
    EXPECT_EQ(scene.name, GetParam());
    EXPECT_EQ(scene.sky_radiance, first.description.sky_radiance);
    EXPECT_EQ(scene.exposure, first.description.exposure);
    EXPECT_EQ(scene.head_radius_m, first.description.head_radius_m);
    EXPECT_EQ(scene.sun.has_value(), first.description.sun.has_value());
    ASSERT_EQ(scene.camera_path.keys().size(), first.description.camera_path.keys().size());
    for (std::size_t i = 0; i < scene.camera_path.keys().size(); ++i) {
        const auto &a = scene.camera_path.keys()[i], &b = first.description.camera_path.keys()[i];
        EXPECT_EQ(a.time_s, b.time_s);
        EXPECT_EQ(a.pose.position_m, b.pose.position_m);
        EXPECT_GT(std::abs(glm::dot(a.pose.orientation, b.pose.orientation)), 1 - 1e-12);
    }
    const SceneModel model = load_model(scene.model);
    EXPECT_EQ(model.triangle_count(), first.model.triangle_count());
    EXPECT_EQ(model.instances.size(), first.model.instances.size());
    EXPECT_EQ(model.textures.size(), first.model.textures.size());
    EXPECT_EQ(instance_transforms(model, scene, 0.5).size(), model.instances.size());
    ASSERT_EQ(scene.moving.size(), first.description.moving.size());
}

INSTANTIATE_TEST_SUITE_P(All, BundledScene,
                         testing::Values("pavilion", "orientation", "sphere", "furnace", "motion", "materials", "leaf",
                                         "near", "poles", "seam", "wires", "mirror", "glass", "inside", "grazing",
                                         "sky"),
                         [](const auto& tested) { return tested.param; });

TEST(Pavilion, IsWithinItsBudgetsAndPassesCloseBy) {
    const GeneratedScene& scene = pavilion();
    EXPECT_GE(scene.model.triangle_count(), 100'000u);
    EXPECT_LE(scene.model.triangle_count(), 600'000u);
    EXPECT_LT(glb_bytes(scene.model).size(), 10'000'000u);
    EXPECT_EQ(scene.description.camera_path.keys().size(), 150u);
    const auto& keys = scene.description.camera_path.keys();
    const glm::dvec3 first = keys.front().pose.orientation * glm::dvec3(0, 0, -1);
    const glm::dvec3 last = keys.back().pose.orientation * glm::dvec3(0, 0, -1);
    EXPECT_LT(glm::dot(first, last), 0) << "turns by more than 90 degrees";
    for (std::size_t i = 1; i < keys.size(); ++i) {
        const double speed = glm::length(keys[i].pose.position_m - keys[i - 1].pose.position_m) * 30;
        EXPECT_GT(speed, 1.0);
        EXPECT_LT(speed, 2.0);
    }
    std::size_t leaves = 0;
    for (const Instance& instance : scene.model.instances)
        leaves += scene.model.materials[scene.model.meshes[instance.mesh].material].alpha_mask != no_index;
    EXPECT_GT(leaves, 300u);
}

TEST(Pavilion, BallRollsWithoutSlipping) {
    const PosePath& path = pavilion().description.moving.at(0).path;
    for (std::size_t i = 1; i < path.keys().size(); ++i) {
        const Pose &a = path.keys()[i - 1].pose, &b = path.keys()[i].pose;
        const glm::dquat turn = b.orientation * glm::inverse(a.orientation);
        EXPECT_NEAR(2 * std::acos(std::min(1.0, std::abs(turn.w))) * a.position_m.y,
                    glm::length(b.position_m - a.position_m), 1e-6);
    }
}

TEST(SphereScene, EveryFacetLiesBetweenTheBoundAndTheRadius) {
    for (const int n : {4, 17, 64, 256}) {
        const SceneModel model = made("sphere", {"radius=3", "n=" + std::to_string(n)}).model;
        const Mesh& mesh = model.meshes.at(0);
        double nearest = 3, farthest = 0;
        for (const glm::vec3& p : mesh.positions)
            farthest = std::max(farthest, glm::length(glm::dvec3(p)));
        for (const glm::uvec3& t : mesh.triangles) {
            const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
            const glm::dvec3 normal = glm::cross(b - a, c - a);
            nearest = std::min(nearest, std::abs(glm::dot(a, normal)) / glm::length(normal));
            EXPECT_LT(glm::dot(normal, a), 0) << "wound to be seen from inside";
        }
        EXPECT_NEAR(farthest, 3, 1e-6);
        EXPECT_GE(nearest, 3 * std::cos(3.141592653589793 / n) - 1e-6) << "n = " << n;
        // And the mesh is no finer than it says: twice the sag would be within a coarser bound.
        EXPECT_LE(nearest, 3 * std::cos(0.8 * 3.141592653589793 / n)) << "n = " << n;
    }
}

TEST(OrientationScene, NoTwoSidesAreAlike) {
    const SceneModel model = made("orientation").model;
    std::set<std::vector<std::uint8_t>> textures;
    for (const Texture& texture : model.textures)
        textures.insert(texture.encoded);
    EXPECT_EQ(textures.size(), 6u);
}

TEST(EmptyScene, IsRefusedWithItsName) {
    const ScratchFolder folder("empty");
    const auto description = write_scene(made("empty"), folder.path());
    try {
        load_model(load_scene(description).model);
        FAIL() << "an empty model was accepted";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("empty.glb"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("triangle"), std::string::npos) << error.what();
    }
}

std::string complaint(const std::function<void()>& action) {
    try {
        action();
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(Generators, BadNamesAndOptionsAreNamedWithTheAcceptedOnes) {
    EXPECT_EQ(complaint([] { find_generator("castle"); }),
              "NAME: expected one of pavilion, orientation, sphere, furnace, motion, materials, leaf, near, poles, "
              "seam, wires, "
              "mirror, glass, inside, grazing, sky, empty, found 'castle'");
    EXPECT_EQ(complaint([] { made("sphere", {"size=3"}); }),
              "options of sphere: expected NAME=VALUE with a name of radius, n, offset, found 'size=3'");
    EXPECT_EQ(complaint([] { made("sphere", {"n"}); }),
              "options of sphere: expected NAME=VALUE with a name of radius, n, offset, found 'n'");
    EXPECT_EQ(complaint([] { made("orientation", {"n=3"}); }), "options of orientation: expected none, found 'n=3'");
    EXPECT_EQ(complaint([] { made("sphere", {"n=1e9"}); }), "option n: expected a number from 4 to 2048, found '1e9'");
    EXPECT_NE(complaint([] { made("sphere", {"radius=nan"}); }).find("found 'nan'"), std::string::npos);
    EXPECT_EQ(complaint([] { made("furnace", {"kind=cold"}); }),
              "option kind: expected one of open, closed, found 'cold'");
}

}  // namespace
}  // namespace equistream

namespace equistream::generate {
namespace {

using Corner = std::tuple<float, float, float>;

/// Every directed edge, by position, must occur as often as its opposite: the surface is closed and consistently wound.
bool is_closed(const Shape& shape) {
    std::map<std::pair<Corner, Corner>, int> balance;
    const auto corner = [&](unsigned i) {
        const glm::vec3 p = shape.positions[i] + 0.0f;  // -0 is 0
        return Corner(p.x, p.y, p.z);
    };
    for (const glm::uvec3& t : shape.triangles)
        for (int k = 0; k < 3; ++k) {
            const Corner a = corner(t[k]), b = corner(t[(k + 1) % 3]);
            ++balance[{a, b}];
            --balance[{b, a}];
        }
    for (const auto& [edge, count] : balance)
        if (count != 0)
            return false;
    return true;
}

/// By the divergence theorem; positive when the winding is counter-clockwise from outside.
double volume(const Shape& shape) {
    double six_volumes = 0;
    for (const glm::uvec3& t : shape.triangles)
        six_volumes += glm::dot(glm::dvec3(shape.positions[t.x]),
                                glm::cross(glm::dvec3(shape.positions[t.y]), glm::dvec3(shape.positions[t.z])));
    return six_volumes / 6;
}

void expect_normals_agree_with_winding(const Shape& shape) {
    for (const glm::uvec3& t : shape.triangles) {
        const glm::vec3 n =
            glm::cross(shape.positions[t.y] - shape.positions[t.x], shape.positions[t.z] - shape.positions[t.x]);
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(glm::length(shape.normals[t[k]]), 1, 1e-4f);
            EXPECT_GT(glm::dot(n, shape.normals[t[k]]), 0);
        }
    }
}

TEST(Shapes, BoxesAreClosedAndHaveTheirVolume) {
    const Shape plain = box({2, 3, 4});
    EXPECT_TRUE(is_closed(plain));
    EXPECT_NEAR(volume(plain), 24, 1e-5);
    expect_normals_agree_with_winding(plain);
    const Shape cut = bevelled_box({2, 3, 4}, 0.1f);
    EXPECT_TRUE(is_closed(cut));
    // Edges lose b^2/2 along their inner length, corners (a cube of side b each) 5/6 of b^3.
    EXPECT_NEAR(volume(cut), 24 - 0.5 * 0.01 * 4 * (1.8 + 2.8 + 3.8) - 8 * 5.0 / 6 * 0.001, 1e-4);
    expect_normals_agree_with_winding(cut);
}

TEST(Shapes, SphereIsClosedAndHasItsVolume) {
    const Shape ball = sphere(2, 192, 96);
    EXPECT_TRUE(is_closed(ball));
    EXPECT_NEAR(volume(ball) / (4.0 / 3 * 3.14159265 * 8), 1, 1.5e-3);
    expect_normals_agree_with_winding(ball);
    EXPECT_NEAR(volume(inside_out(ball)), -volume(ball), 1e-6);
}

TEST(Shapes, LatheOfARectangleIsACylinder) {
    const Shape cylinder = lathe(std::array<glm::vec2, 4>{{{0, 0}, {1, 0}, {1, 2}, {0, 2}}}, 256);
    EXPECT_TRUE(is_closed(cylinder));
    EXPECT_NEAR(volume(cylinder) / (2 * 3.14159265), 1, 2e-4);
    expect_normals_agree_with_winding(cylinder);
}

TEST(Shapes, TubeRingAndCardFaceOutwards) {
    const Shape pipe =
        tube(std::array{glm::vec3(0), glm::vec3(1, 1, 0), glm::vec3(1, 3, 1)}, std::array{0.2f, 0.2f, 0.1f}, 16);
    expect_normals_agree_with_winding(pipe);
    for (std::size_t i = 0; i < 16; ++i)
        EXPECT_GT(glm::dot(pipe.normals[i], pipe.positions[i]), 0);
    const Shape washer = ring(0.5f, 1, 64);
    expect_normals_agree_with_winding(washer);
    EXPECT_GT(washer.normals[0].y, 0.99f);
    const Shape flat = card(2, 1);
    expect_normals_agree_with_winding(flat);
    EXPECT_GT(flat.normals[0].z, 0.99f);
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ(flat.uvs[i], glm::vec2(flat.positions[i].x > 0, flat.positions[i].y < 0));
}

TEST(Shapes, AppendTurnsMirroredPartsAround) {
    Shape both;
    append(both, box({1, 1, 1}), glm::mat4(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1));
    EXPECT_NEAR(volume(both), 1, 1e-5);
    expect_normals_agree_with_winding(both);
}

TEST(Noise, RepeatsWithItsPeriodAndKeepsItsRange) {
    Random random(1);
    float low = 0, high = 0;
    for (int i = 0; i < 20000; ++i) {
        const glm::vec2 p(random.between(0, 6), random.between(0, 3));
        const float value = noise(p, {6, 3}, 9);
        EXPECT_NEAR(value, noise(p + glm::vec2(6, -3), {6, 3}, 9), 1e-4f);
        low = std::min(low, value);
        high = std::max(high, value);
    }
    EXPECT_GT(low, -1.1f);
    EXPECT_LT(low, -0.5f);
    EXPECT_GT(high, 0.5f);
    EXPECT_LT(high, 1.1f);
}

TEST(Paint, PngKeepsEverySampleAndAlphaUnmultiplied) {
    const ByteImage image = paint(33, 17, 4, [](glm::vec2 at) { return glm::vec4(at, 0.8f, 0.1f + 0.5f * at.x); });
    std::vector<std::uint8_t> bytes = encode_image(image, Encoding::png);
    OIIO::Filesystem::IOMemReader memory(bytes.data(), bytes.size());
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    OIIO::Filesystem::IOProxy* proxy = &memory;
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    const auto input = OIIO::ImageInput::open("image.png", &config);
    ASSERT_TRUE(input) << OIIO::geterror();
    ASSERT_EQ(input->spec().nchannels, 4);
    std::vector<std::uint8_t> read(33 * 17 * 4);
    ASSERT_TRUE(input->read_image(0, 0, 0, 4, OIIO::TypeDesc::UINT8, read.data()));
    EXPECT_TRUE(std::equal(read.begin(), read.end(), image.samples().begin()));
}

TEST(Paint, TextHasOnlyLettersItKnows) {
    EXPECT_NEAR(distance_to_text("I", {0.3f, 0.5f}), 0, 1e-6f);
    EXPECT_NEAR(distance_to_text("I", {0.3f, 1.5f}), 0.5f, 1e-6f);
    EXPECT_THROW(distance_to_text("a", {0, 0}), InputError);
}

}  // namespace
}  // namespace equistream::generate
