#include <host-adapters/embree/mip_chain.h>
#include <host-adapters/embree/textures.h>

#include <host-adapters/embree/sampler.h>

#include <equistream/error.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace equistream::embree_host {
namespace {

using Paint = std::function<glm::u8vec4(int x, int y)>;

Texture make_png(int width, int height, const Paint& paint, int channels = 3) {
    std::vector<std::uint8_t> pixels;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < channels; ++c)
                pixels.push_back(paint(x, y)[c]);
    Texture texture;
    texture.name = "painted";
    texture.mime_type = "image/png";
    OIIO::Filesystem::IOVecOutput bytes;
    const auto output = OIIO::ImageOutput::create("png");
    OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    EXPECT_TRUE(output->set_ioproxy(&bytes));
    EXPECT_TRUE(output->open("painted.png", spec));
    EXPECT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
    output->close();
    texture.encoded = bytes.buffer();
    return texture;
}

SceneModel model_with(Texture texture) {
    SceneModel model;
    model.textures.push_back(std::move(texture));
    model.materials.push_back({});
    model.materials[0].base_colour_texture = 0;
    return model;
}

float srgb_decoded(int code) {
    const double v = code / 255.0;
    return static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
}

/// Every texel tells where it is.
glm::u8vec4 coordinates(int x, int y) {
    return {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 100, 255};
}

glm::vec3 at(Textures::Reader& reader, float u, float v, float footprint = 0) {
    return reader.lookup(0, {{u, v}, footprint, glm::vec3(0.5f)});
}

glm::vec3 as_data(Textures::Reader& reader, float u, float v) {
    return reader.lookup(0, {{u, v}, 0, glm::vec3(0.5f), TextureCoding::data});
}

TEST(Textures, TopRowIsAtVZeroAndColoursAreDecoded) {
    for (const int width : {16, 64, 200}) {  // held whole as the coarse level, and in the texture system
        const SceneModel model = model_with(make_png(width, 50, coordinates));
        const Textures textures(model);
        Textures::Reader reader(textures);
        for (const auto& [x, y] : {std::pair{3, 7}, {0, 0}, {width - 1, 49}, {5, 48}}) {
            const glm::vec3 c = at(reader, (static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                                   (static_cast<float>(y) + 0.5f) / 50);
            EXPECT_NEAR(c.x, srgb_decoded(x), 1e-6) << width << ": " << x << "," << y;
            EXPECT_NEAR(c.y, srgb_decoded(y), 1e-6) << width << ": " << x << "," << y;
            EXPECT_NEAR(c.z, srgb_decoded(100), 1e-6);
        }
    }
}

TEST(Textures, DataIsNotDecoded) {
    SceneModel model = model_with(make_png(64, 64, coordinates));
    model.materials[0].base_colour_texture = no_index;
    model.materials[0].metallic_roughness_texture = 0;
    const Textures textures(model);
    Textures::Reader reader(textures);
    EXPECT_NEAR(as_data(reader, 10.5f / 64, 20.5f / 64).y, 20 / 255.0, 1e-6);
}

TEST(Textures, ColourToOneMaterialAndDataToAnotherIsEachInItsCoding) {
    for (const int side : {16, 64}) {  // held whole as the coarse level, and in the texture system
        SceneModel model = model_with(make_png(side, side, coordinates));
        model.materials.push_back({});
        model.materials[1].metallic_roughness_texture = 0;
        const Textures textures(model);
        Textures::Reader reader(textures);
        const float s = static_cast<float>(side);
        EXPECT_NEAR(at(reader, 10.5f / s, 7.5f / s).y, srgb_decoded(7), 1e-6) << side;
        EXPECT_NEAR(as_data(reader, 10.5f / s, 7.5f / s).y, 7 / 255.0, 1e-6) << side;
        EXPECT_NEAR(textures.mean(0).z, srgb_decoded(100), 1e-5) << side;
    }
}

TEST(Textures, TheSecondCodingCanBeTheFirstMaterials) {
    SceneModel model = model_with(make_png(64, 64, coordinates));
    model.materials[0].base_colour_texture = no_index;
    model.materials[0].metallic_roughness_texture = 0;
    model.materials.push_back({});
    model.materials[1].emission_texture = 0;
    const Textures textures(model);
    Textures::Reader reader(textures);
    EXPECT_NEAR(at(reader, 10.5f / 64, 20.5f / 64).x, srgb_decoded(10), 1e-6);
    EXPECT_NEAR(as_data(reader, 10.5f / 64, 20.5f / 64).x, 10 / 255.0, 1e-6);
}

TEST(Textures, WrapsAsAsked) {
    for (const int side : {16, 64}) {
        const auto column = [&](Wrap wrap, float u) {
            Texture texture = make_png(side, side, coordinates);
            texture.wrap_u = wrap;
            const SceneModel model = model_with(std::move(texture));
            const Textures textures(model);
            Textures::Reader reader(textures);
            const float red = at(reader, u, 0.5f).x;
            for (int x = 0; x < side; ++x)
                if (std::abs(red - srgb_decoded(x)) < 1e-7f)
                    return x;
            return -1;
        };
        const float s = static_cast<float>(side);
        EXPECT_EQ(column(Wrap::repeat, 1 + 3.5f / s), 3);
        EXPECT_EQ(column(Wrap::repeat, -3.5f / s), side - 4);
        EXPECT_EQ(column(Wrap::clamp, 1.7f), side - 1);
        EXPECT_EQ(column(Wrap::clamp, -0.2f), 0);
        EXPECT_EQ(column(Wrap::mirror, 1 + 3.5f / s), side - 4);
        EXPECT_EQ(column(Wrap::mirror, -3.5f / s), 3);
    }
}

TEST(Textures, MeanOfJitteredLookupsIsBilinearInLinearLight) {
    const SceneModel model = model_with(make_png(
        64, 64, [](int x, int) { return x < 32 ? glm::u8vec4(0, 0, 0, 255) : glm::u8vec4(255, 255, 255, 255); }));
    const Textures textures(model);
    Textures::Reader reader(textures);
    for (const float from_edge : {-0.25f, 0.0f, 0.4f}) {
        double sum = 0;
        constexpr int n = 4096;
        for (int i = 0; i < n; ++i) {
            Sampler random(static_cast<std::uint64_t>(i), 0);
            const glm::vec3 jitter{random.next_hashed(), random.next_hashed(), random.next_hashed()};
            sum += reader.lookup(0, {{(32 + from_edge) / 64, 0.3f}, 0.5f / 64, jitter}).x;
        }
        EXPECT_NEAR(sum / n, 0.5 + from_edge, 5 * 0.5 / std::sqrt(n)) << from_edge;
    }
}

TEST(Textures, CoarseLevelsAverageLightNotCodes) {
    const SceneModel model = model_with(make_png(256, 256, [](int x, int y) {
        return (x + y) % 2 ? glm::u8vec4(255, 255, 255, 255) : glm::u8vec4(0, 0, 0, 255);
    }));
    const Textures textures(model);
    Textures::Reader reader(textures);
    for (const float texels : {2.1f, 4.1f, 30.0f, 1000.0f})
        EXPECT_NEAR(at(reader, 0.3f, 0.6f, texels / 256).x, 0.5, 0.005) << texels;
    EXPECT_NEAR(textures.mean(0).y, 0.5, 0.005);
}

TEST(Textures, LevelsFollowTheFootprint) {
    // Stripes one texel wide, 16 texels of each shade block: level n is visible in how sharp a block edge is.
    const SceneModel model = model_with(make_png(256, 256, [](int x, int) {
        const auto shade = static_cast<std::uint8_t>(x);
        return glm::u8vec4(shade, shade, shade, 255);
    }));
    const Textures textures(model);
    Textures::Reader reader(textures);
    // Within one texel of level 2 (four wide) a lookup is constant; at level 0 it is not.
    EXPECT_EQ(at(reader, 100.5f / 256, 0.5f, 4.0f / 256), at(reader, 103.4f / 256, 0.5f, 4.0f / 256));
    EXPECT_NE(at(reader, 100.5f / 256, 0.5f, 0.9f / 256), at(reader, 103.4f / 256, 0.5f, 0.9f / 256));
}

/// Within one texel of the level that the footprint asks for, a lookup is constant. With a footprint of 0.4 times as
/// much it is not.
TEST(Textures, LevelsFollowTheFootprintWhateverTheShape) {
    const auto shade_of_column = [](int x, int) {
        const auto shade = static_cast<std::uint8_t>(x);
        return glm::u8vec4(shade, shade, shade, 255);
    };
    for (const auto& [width, height, texels] :
         {std::tuple{1024, 256, 4.0f}, {1024, 256, 16.0f}, {4096, 512, 32.0f}, {4096, 16, 8.0f}}) {
        const SceneModel model = model_with(make_png(width, height, shade_of_column));
        const Textures textures(model);
        Textures::Reader reader(textures);
        const auto w = static_cast<float>(width);
        const float first = 512.5f, last = first + texels - 0.7f;
        EXPECT_EQ(at(reader, first / w, 0.5f, texels / w), at(reader, last / w, 0.5f, texels / w))
            << width << 'x' << height << ": one texel of the level";
        EXPECT_NE(at(reader, first / w, 0.5f, 0.4f * texels / w), at(reader, last / w, 0.5f, 0.4f * texels / w));
    }
    // Beyond the level on which the shorter side is one texel, which the texture system never takes.
    const SceneModel model = model_with(make_png(4096, 16, shade_of_column));
    const Textures textures(model);
    Textures::Reader reader(textures);
    const glm::vec3 light = reader.lookup(0, {{0.3f, 0.5f}, 64.0f / 4096, {0.9f, 0.1f, 0.5f}});
    EXPECT_TRUE(light.x > 0 && light.x < 1) << light.x;
}

TEST(Textures, AlphaThatCutsNothingAwayWeighsNothing) {
    const Texture half_clear = make_png(
        64, 64, [](int x, int) { return x % 2 ? glm::u8vec4(0, 0, 0, 0) : glm::u8vec4(255, 255, 255, 255); }, 4);
    for (const bool is_cut : {false, true}) {
        SceneModel model = model_with(half_clear);
        model.materials[0].alpha_mask = is_cut ? 0 : no_index;
        const Textures textures(model);
        Textures::Reader reader(textures);
        EXPECT_NEAR(at(reader, 0.4f, 0.5f, 16.0f / 64).x, is_cut ? 1 : 0.5, 0.005);
        EXPECT_NEAR(textures.mean(0).x, is_cut ? 1 : 0.5, 0.005) << "lamps are chosen by it";
    }
}

TEST(Textures, WhatAMaskCutsAwayDoesNotBleed) {
    const Texture texture = make_png(
        64, 64, [](int x, int) { return x % 2 ? glm::u8vec4(0, 0, 0, 0) : glm::u8vec4(255, 255, 255, 255); }, 4);
    const MipChainSource source{&texture, TextureCoding::colour, true};
    ASSERT_EQ(mip_level_count(64, 64), 7);
    const ByteImage level = make_mip_level(source, 3);
    EXPECT_EQ(level.width(), 8);
    EXPECT_EQ(level.height(), 8);
    EXPECT_GE(level.samples()[0], 254);
}

TEST(Textures, NearestIsNotJittered) {
    Texture texture = make_png(64, 64, coordinates);
    texture.nearest = true;
    const SceneModel model = model_with(std::move(texture));
    const Textures textures(model);
    Textures::Reader reader(textures);
    for (const float j : {0.0f, 0.99f})
        EXPECT_NEAR(reader.lookup(0, {{10.1f / 64, 20.9f / 64}, 0, glm::vec3(j, j, 0)}).x, srgb_decoded(10), 1e-7);
}

TEST(Textures, MayTakeAQuarterOfTheMemoryWithinLimits) {
    EXPECT_EQ(cache_megabytes(512 * 0x1p30), 4096.0f) << "others may need the rest";
    EXPECT_EQ(cache_megabytes(16 * 0x1p30), 4096.0f);
    EXPECT_EQ(cache_megabytes(8 * 0x1p30), 2048.0f);
    EXPECT_EQ(cache_megabytes(3 * 0x1p30), 768.0f);
    EXPECT_EQ(cache_megabytes(1 * 0x1p30), 512.0f);
    EXPECT_EQ(cache_megabytes(0), 512.0f) << "not known";
}

TEST(Textures, DamagedImagesAreNamed) {
    const auto message = [](Texture texture) {
        try {
            const SceneModel model = model_with(std::move(texture));
            const Textures textures(model);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string("none");
    };
    Texture cut =
        make_png(64, 64, [](int x, int y) { return glm::u8vec4(x * 37 % 251, y * 91 % 241, x * y % 239, 255); });
    cut.encoded.resize(cut.encoded.size() / 2);
    EXPECT_NE(message(cut).find("painted"), std::string::npos) << message(cut);
    Texture cut_jpeg;
    cut_jpeg.name = "photo";
    cut_jpeg.encoded = {0xff, 0xd8, 0xff, 0xe0, 0, 16, 'J', 'F', 'I', 'F'};
    EXPECT_NE(message(cut_jpeg).find("photo"), std::string::npos) << message(cut_jpeg);
    Texture empty;
    empty.name = "nothing";
    EXPECT_NE(message(empty).find("nothing"), std::string::npos) << message(empty);
}

}  // namespace
}  // namespace equistream::embree_host
