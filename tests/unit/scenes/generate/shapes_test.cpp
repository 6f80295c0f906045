#include <scenes/generate/shapes.h>

#include <scenes/generate/paint.h>

#include <equistream/error.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <tuple>

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
