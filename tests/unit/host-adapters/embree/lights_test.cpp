#include "test_scene.h"

#include <equistream/conventions.h>

#include <scenes/sky/sky_image.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace equistream::embree_host {
namespace {

Material lamp(const glm::vec3& radiance) {
    Material m = matte(glm::vec3(0));
    m.emission = radiance;
    return m;
}

TEST(Sun, ConeSamplesLieInTheDiscAndThePdfIsItsSolidAngle) {
    for (const float radius : {0.00465f, 0.1f, 1.5f}) {
        const SunLight sun({0.3f, 1, -0.2f}, glm::vec3(3), radius);
        const ShadingFrame frame(sun.towards);
        double cosines = 0;
        constexpr std::uint32_t n = 4096;
        for (std::uint32_t i = 0; i < n; ++i) {
            const glm::vec2 u = Sampler(3, i).pair(0, Sampler::Use::sun);
            const glm::vec3 local = sample_cone(u, sun.one_minus_cos);
            EXPECT_LE(std::acos(std::min(1.0f, local.z)), radius * 1.001f);
            cosines += local.z / sun.pdf / n;
        }
        // The irradiance on a plane facing the disc.
        EXPECT_NEAR(cosines * sun.radiance.x, 3, 0.003) << radius;
        EXPECT_TRUE(sun.contains(sun.towards));
        EXPECT_TRUE(sun.contains(frame.to_world({std::sin(0.98f * radius), 0, std::cos(0.98f * radius)})));
        EXPECT_FALSE(sun.contains(frame.to_world({std::sin(1.02f * radius), 0, std::cos(1.02f * radius)})));
    }
}

TEST(Emitters, TrianglesAreChosenByPowerAndPointsUniformly) {
    TestScene scene;
    const auto dim = scene.add_material(lamp(glm::vec3(1))), bright = scene.add_material(lamp(glm::vec3(5)));
    scene.add_material(matte(glm::vec3(0.5f)));
    scene.add(floor_mesh(1, 1, dim));
    // The same mesh twice as long and wide: the transform's area counts.
    scene.add(floor_mesh(1, 1, bright), glm::mat4(2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0, 10, 0, 0, 1));
    scene.build();
    const double total = 1 * 4 + 5 * 16;
    EXPECT_NEAR(scene.shading->material(dim).emission_pdf_area, 1 / total, 1e-7);
    EXPECT_NEAR(scene.shading->material(bright).emission_pdf_area, 5 / total, 1e-7);
    constexpr std::uint32_t n = 20000;
    int from_bright = 0;
    glm::dvec3 centre{0};
    for (std::uint32_t i = 0; i < n; ++i) {
        Sampler random(i, 0);
        const float choice = random.next_hashed();
        const EmitterSample s = scene.lights.emitters.sample(choice, {random.next_hashed(), random.next_hashed()});
        EXPECT_NEAR(s.normal.y, 1, 1e-6);
        if (s.material != bright)
            continue;
        ++from_bright;
        centre += glm::dvec3(s.position);
        EXPECT_NEAR(s.uv.x, (s.position.x - 8) / 4, 1e-5);
        EXPECT_NEAR(s.uv.y, (s.position.z + 2) / 4, 1e-5);
    }
    const double share = 80.0 / 84;
    EXPECT_NEAR(from_bright, n * share, 5 * std::sqrt(n * share * (1 - share)));
    centre /= from_bright;
    EXPECT_NEAR(centre.x, 10, 5 * 4 / std::sqrt(12.0 * n));
    EXPECT_NEAR(centre.z, 0, 5 * 4 / std::sqrt(12.0 * n));
}

TEST(Emitters, AliasTableServesManyUnequalTriangles) {
    TestScene scene;
    std::vector<std::uint32_t> materials;
    for (int i = 0; i < 40; ++i) {
        materials.push_back(scene.add_material(lamp(glm::vec3(static_cast<float>(1 + i % 7)))));
        scene.add(floor_mesh(0.5f, 0.5f * static_cast<float>(1 + i % 3), materials.back()));
    }
    scene.build();
    std::vector<double> counted(materials.size(), 0), expected;
    double total = 0;
    for (int i = 0; i < 40; ++i) {
        expected.push_back((1 + i % 7) * (1 + i % 3));
        total += expected.back();
    }
    constexpr std::uint32_t n = 200000;
    for (std::uint32_t i = 0; i < n; ++i)
        counted[scene.lights.emitters.sample((static_cast<float>(i) + 0.5f) / n, {0.3f, 0.3f}).material] += 1;
    for (std::size_t i = 0; i < counted.size(); ++i)
        EXPECT_NEAR(counted[i], n * expected[i] / total, 6) << i;
}

/// What a plane through the origin, facing up, gets from the samples of the table alone: mean and standard error.
std::pair<double, double> irradiance_by_table(const TestScene& scene) {
    constexpr std::uint32_t n = 200000;
    double sum = 0, squares = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        Sampler random(i, 0);
        const float choice = random.next_hashed();
        const EmitterSample s = scene.lights.emitters.sample(choice, {random.next_hashed(), random.next_hashed()});
        if (s.cut_away)
            continue;
        const ShadingMaterial& material = scene.shading->material(s.material);
        const double distance2 = glm::dot(s.position, s.position);
        const glm::vec3 d = s.position / static_cast<float>(std::sqrt(distance2));
        const double value =
            material.emission.y * d.y * -glm::dot(d, s.normal) / (material.emission_pdf_area * distance2);
        sum += value / n;
        squares += value * value / n;
    }
    return {sum, std::sqrt((squares - sum * sum) / n)};
}

TEST(Emitters, WhatAMaskCutsAwayGivesNoLight) {
    double seen[2];
    for (const bool masked : {false, true}) {
        TestScene scene;
        const std::uint32_t material = scene.add_material(lamp(glm::vec3(3)));
        if (masked) {
            scene.model.alpha_masks.push_back(checker_mask(64));
            scene.model.materials[material].alpha_mask = 0;
        }
        const glm::mat4 turned_over_above(1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0.3f, 2, 0.2f, 1);
        scene.add(floor_mesh(1.5f, 1.5f, material), turned_over_above);
        scene.build();
        const auto [mean, error] = irradiance_by_table(scene);
        EXPECT_LT(error, 0.005 * mean);
        seen[masked] = mean;
    }
    EXPECT_NEAR(seen[1] / seen[0], 0.5, 0.01);
}

TEST(Emitters, AMeshWithoutTextureCoordinatesIsWholeForLightsAsForRays) {
    TestScene scene;
    const std::uint32_t material = scene.add_material(lamp(glm::vec3(3)));
    scene.model.alpha_masks.push_back(checker_mask(2));
    scene.model.materials[material].alpha_mask = 0;
    Mesh mesh = floor_mesh(1, 1, material);
    mesh.uvs.clear();
    scene.add(mesh);
    scene.build();
    for (std::uint32_t i = 0; i < 100; ++i) {
        Sampler random(i, 0);
        EXPECT_FALSE(scene.lights.emitters.sample(0.5f, {random.next_hashed(), random.next_hashed()}).cut_away);
    }
}

}  // namespace

namespace {

using test::expect_contains;
using test::input_error;

class SkyImageFile : public test::TemporaryFolder {
protected:
    /// Writes `samples` (interleaved) as the format that the name's extension says.
    std::filesystem::path save(const std::string& name, OIIO::ImageSpec spec, const std::vector<float>& samples) const {
        const std::filesystem::path file = folder_ / name;
        const auto out = OIIO::ImageOutput::create(file.string());
        EXPECT_TRUE(out && out->open(file.string(), spec)) << OIIO::geterror();
        EXPECT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, samples.data())) << out->geterror();
        EXPECT_TRUE(out->close());
        return file;
    }
    std::string error(const std::filesystem::path& file) const {
        const std::string text = input_error([&] { read_sky_image(file); });
        EXPECT_EQ(text.rfind(file.string(), 0), 0u) << text;
        EXPECT_EQ(text.find('\n'), std::string::npos) << text;
        return text;
    }
};

const OIIO::ImageSpec small(4, 2, 3, OIIO::TypeDesc::FLOAT);

std::vector<float> ramp(std::size_t n) {
    std::vector<float> samples(n);
    for (std::size_t i = 0; i < n; ++i)
        samples[i] = 0.5f * static_cast<float>(i);
    return samples;
}

TEST_F(SkyImageFile, OpenExrAndRadianceAreReadTopRowFirst) {
    for (const char* name : {"sky.exr", "sky.hdr"}) {
        const FloatImage image = read_sky_image(save(name, small, ramp(24)));
        ASSERT_EQ(image.width(), 4);
        ASSERT_EQ(image.height(), 2);
        for (std::size_t i = 0; i < 24; ++i)
            EXPECT_NEAR(image.samples()[i], 0.5f * static_cast<float>(i), 0.01f * 0.5f * static_cast<float>(i) + 0.02f)
                << name << " " << i;
    }
}

TEST_F(SkyImageFile, AQuestionMarkInItsPathIsOne) {
    const std::filesystem::path file = folder_ / "what?" / "sky.exr";
    std::filesystem::create_directory(file.parent_path());
    std::filesystem::rename(save("sky.exr", small, ramp(24)), file);
    EXPECT_EQ(read_sky_image(file).samples()[23], 11.5f);
    std::ofstream(file) << "no image";
    expect_contains(error(file), "a readable sky image");
}

TEST_F(SkyImageFile, GreyIsRepeatedAndAlphaLeftAlone) {
    const FloatImage grey =
        read_sky_image(save("grey.exr", OIIO::ImageSpec(2, 1, 1, OIIO::TypeDesc::HALF), {0.25f, 8}));
    EXPECT_EQ(std::vector<float>(grey.samples().begin(), grey.samples().end()),
              (std::vector<float>{0.25f, 0.25f, 0.25f, 8, 8, 8}));
    const FloatImage rgba =
        read_sky_image(save("rgba.exr", OIIO::ImageSpec(1, 1, 4, OIIO::TypeDesc::FLOAT), {1, 2, 3, 0.5f}));
    EXPECT_EQ(rgba.pixel(0, 0)[2], 3);
}

TEST_F(SkyImageFile, PrimariesThatTheFileNamesBecomeRec709) {
    OIIO::ImageSpec acescg(2, 1, 3, OIIO::TypeDesc::FLOAT);
    const float primaries[8] = {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f};
    acescg.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), primaries);
    const FloatImage image = read_sky_image(save("acescg.exr", acescg, {0.2f, 0.4f, 0.6f, 0, 1, 0}));
    // The matrix that colour-science publishes for ACEScg to linear Rec.709 by Bradford's method.
    const double expected[3] = {1.705051 * 0.2 - 0.621792 * 0.4 - 0.083259 * 0.6,
                                -0.130257 * 0.2 + 1.140805 * 0.4 - 0.010548 * 0.6,
                                -0.024004 * 0.2 - 0.128969 * 0.4 + 1.152972 * 0.6};
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(image.pixel(0, 0)[c], expected[c], 1e-4) << c;
    EXPECT_EQ(image.pixel(1, 0)[0], 0) << "a green beyond Rec.709's";
    EXPECT_NEAR(image.pixel(1, 0)[1], 1.140805, 1e-4);
    const float line[8] = {0.1f, 0.1f, 0.2f, 0.2f, 0.3f, 0.3f, 0.32168f, 0.33767f};
    acescg.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), line);
    expect_contains(error(save("line.exr", acescg, ramp(6))), "expected chromaticities that span a triangle");
}

TEST_F(SkyImageFile, BadPixelsAreNamed) {
    for (const auto& [value, name] :
         {std::pair{-1.0f, "-1.0"}, {std::nanf(""), "nan"}, {std::numeric_limits<float>::infinity(), "inf"}}) {
        std::vector<float> samples = ramp(24);
        samples[3 * (4 * 1 + 2) + 1] = value;
        const std::string text = error(save("bad.exr", small, samples));
        expect_contains(text, "pixel (2, 1): expected radiance that is finite and not negative, found");
        expect_contains(text, name);
    }
}

TEST_F(SkyImageFile, WhatIsNoSkyIsRefused) {
    expect_contains(error(folder_ / "none.exr"), "expected a readable sky image");
    expect_contains(error(write("text.exr", "not an image")), "expected a readable sky image");
    expect_contains(error(save("eight.png", OIIO::ImageSpec(2, 1, 3, OIIO::TypeDesc::UINT8), ramp(6))),
                    "floating-point radiance (.exr, .hdr), found pixels of type uint8");
    expect_contains(error(save("two.exr", OIIO::ImageSpec(2, 1, 2, OIIO::TypeDesc::FLOAT), ramp(4))),
                    "expected channels R, G and B");
    OIIO::ImageSpec odd(2, 1, 3, OIIO::TypeDesc::FLOAT);
    odd.channelnames = {"R\x9b", "G", "B"};  // to a terminal the beginning of a control sequence
    expect_contains(error(save("odd.exr", odd, ramp(6))), "R?");
    OIIO::ImageSpec cube = small;
    cube.attribute("textureformat", "CubeFace Environment");
    expect_contains(error(save("cube.exr", cube, ramp(24))),
                    "expected a lat-long sky image, found the faces of a cube");
    OIIO::ImageSpec crop = small;
    crop.full_width = 8;
    expect_contains(error(save("crop.exr", crop, ramp(24))), "4x2 of its 8x2 pixels");
}

TEST_F(SkyImageFile, ACutFileIsRefused) {
    for (const char* name : {"cut.exr", "cut.hdr"}) {
        const auto file = save(name, OIIO::ImageSpec(64, 32, 3, OIIO::TypeDesc::FLOAT), ramp(64 * 32 * 3));
        std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
        error(file);
    }
}

TEST_F(SkyImageFile, TooLargeOnesAreRefusedByTheirHeaders) {
    write("huge.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 30000 +X 30000\n");
    expect_contains(error(folder_ / "huge.hdr"), "found 30000x30000");
}

/// Three balls, apart, one in another and one around the point that they are seen from.
std::vector<float> three_openings() {
    std::vector<float> numbers;
    OpeningList::append(
        std::vector<SkyOpening>{{{3, 1, 0}, 0.5f, 0.5f}, {{-4, 2, 1}, 2, 0.3f}, {{-4, 2.2f, 1}, 0.1f, 0.2f}}, numbers);
    return numbers;
}

TEST(Openings, DensityIntegratesToOneFromOutsideAndInsideABall) {
    const std::vector<float> numbers = three_openings();
    const OpeningList list(numbers);
    for (const glm::vec3& from : {glm::vec3(0), glm::vec3(-4, 2, 0), glm::vec3(3, 1.1f, 0.1f), glm::vec3(30, -20, 5)}) {
        double integral = 0;
        constexpr int n = 2000;
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                const glm::vec2 u{(static_cast<float>(x) + 0.5f) / n, (static_cast<float>(y) + 0.5f) / n};
                integral += list.pdf(from, sample_cone(u, 2)) * 4 * pi / n / n;
            }
        EXPECT_NEAR(integral, 1, 0.01) << from.x;
    }
}

TEST(Openings, SmallBallsFarAwayHaveADensityWhereTheyAreSampled) {
    std::vector<float> numbers;
    const glm::vec3 from(1, 2, 3);
    OpeningList::append(std::vector<SkyOpening>{{from + glm::vec3(60, 50, -62), 1e-3f, 1}}, numbers);
    const OpeningList list(numbers);
    int outside = 0;
    for (std::uint32_t i = 0; i < 10000; ++i) {
        Sampler numbers_of(i, 4);
        outside += !(list.pdf(from, list.sample(from, {numbers_of.next_hashed(), numbers_of.next_hashed()})) > 0);
    }
    EXPECT_LT(outside, 10);
}

TEST(Openings, SamplesAreSpreadAsTheDensitySays) {
    const std::vector<float> numbers = three_openings();
    const OpeningList list(numbers);
    const glm::vec3 from(0.5f, 0, 0);
    // The mean of a function over samples is its integral times the density.
    const auto function = [](const glm::vec3& d) { return 1 + d.x + d.y * d.z + d.y * d.y; };
    double sampled = 0, squares = 0, integral = 0;
    int on_edges = 0;  // rounded out of the ball
    constexpr std::uint32_t n = 1 << 16;
    constexpr int cells = 2000;
    for (std::uint32_t i = 0; i < n; ++i) {
        Sampler numbers_of(i, 4);
        const glm::vec3 d = list.sample(from, {numbers_of.next_hashed(), numbers_of.next_hashed()});
        ASSERT_NEAR(glm::length(d), 1, 1e-5);
        on_edges += !(list.pdf(from, d) > 0);
        sampled += function(d) / n;
        squares += function(d) * function(d) / n;
    }
    for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x) {
            const glm::vec3 d =
                sample_cone({(static_cast<float>(x) + 0.5f) / cells, (static_cast<float>(y) + 0.5f) / cells}, 2);
            integral += list.pdf(from, d) * function(d) * 4 * pi / cells / cells;
        }
    EXPECT_LT(on_edges, 8);
    EXPECT_NEAR(sampled, integral, 4 * std::sqrt((squares - sampled * sampled) / n) + 0.005);
}

}  // namespace
}  // namespace equistream::embree_host
