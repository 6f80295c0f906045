// Cryptomatte by the C ABI: hashes by known answers, coverage by the samples that each id was met by.
#include "abi_fixture.h"

#include <equistream/cryptomatte.h>

#include <OpenImageIO/imageio.h>

#include <bit>
#include <cmath>
#include <map>

namespace equistream::testing {
namespace {

/// Answers of the specification (torus, равнина, bunny, default) and of MurmurHash3's author's program.
TEST(Cryptomatte, NamesHaveTheSpecificationsHashes) {
    EXPECT_EQ(cryptomatte_hash(""), 0u);
    EXPECT_EQ(cryptomatte_hash("hello"), 0x248bfa47u);
    EXPECT_EQ(cryptomatte_hash("torus"), 4053562365u);
    EXPECT_EQ(cryptomatte_hash("\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0"), 2518896926u);
    EXPECT_EQ(std::bit_cast<std::uint32_t>(cryptomatte_id("bunny")), 0x13851a76u);
    EXPECT_EQ(std::bit_cast<std::uint32_t>(cryptomatte_id("default")), 0x42c9679fu);
    EXPECT_NEAR(cryptomatte_id("torus"), -1.54943624832e+30, 1e24);
}

/// Names whose hashes have an exponent of 0 or 255 are found by trying; all ids are normal numbers.
TEST(Cryptomatte, IdsAreNormalNumbers) {
    int changed = 0;
    for (int i = 0; i < 20'000; ++i) {
        const std::string name = "object " + std::to_string(i);
        const float id = cryptomatte_id(name);
        EXPECT_TRUE(std::isnormal(id)) << name;
        const std::uint32_t hash = cryptomatte_hash(name), bits = std::bit_cast<std::uint32_t>(id);
        EXPECT_TRUE(bits == hash || (bits ^ hash) == 1u << 23) << name;
        changed += bits != hash;
    }
    EXPECT_GT(changed, 20'000 / 128 / 2);
    EXPECT_LT(changed, 20'000 / 128 * 2);
}

class AbiCryptomatte : public AbiTest {
protected:
    /// What sample `pass` of a pixel meets.
    using Met = std::function<std::pair<std::uint32_t, std::uint32_t>(int x, int y, std::uint32_t pass)>;

    static void fill(es_frame* frame, const Met& met, std::uint32_t passes) {
        es_tile tile{};
        while (es_frame_next_tile(frame, &tile) == ES_OK) {
            std::vector<es_ray> rays(tile.pixel_count);
            std::vector<es_surface> surfaces(tile.pixel_count);
            es_tile_geometry_rays(frame, &tile, rays.data());
            es_tile_put_surfaces(frame, &tile, surfaces.data());
            const std::vector<float> rgba(tile.pixel_count * 4);
            for (std::uint32_t pass = 0; pass < tile.sample_count; ++pass) {
                es_tile_colour_rays(frame, &tile, pass, rays.data());
                es_tile_put_radiance(frame, &tile, rgba.data());
                std::vector<std::uint32_t> ids;
                for (std::uint32_t i = 0; i < tile.pixel_count; ++i) {
                    const auto [object, material] =
                        met(tile.x + int(i) % tile.width, tile.y + int(i) / tile.width, pass);
                    ids.insert(ids.end(), {object, material});
                }
                if (pass < passes)
                    es_tile_put_ids(frame, &tile, ids.data());
            }
        }
    }

    Frame of_eight_passes(const Met& met) {
        settings.spp = 8;
        es_sequence* sequence = open();
        es_frame* frame = begin(sequence, at(0));
        fill(frame, met, 8);
        end(frame);
        es_sequence_close(sequence);
        return read(0);
    }

    /// In the middle these two objects, and no others.
    static void expect_two(const Frame& made, const char* first, float share, const char* second, float other_share) {
        const float* pixel = made.planes.at("crypto_object").pixel(40, 20);
        const float expected[12] = {cryptomatte_id(first), share, cryptomatte_id(second), other_share};
        for (int c = 0; c < 12; ++c)
            EXPECT_EQ(pixel[c], expected[c]) << c;
    }

    void name_three_of_two_names() {
        objects.push_back("bunny");
        name_two();
        settings.object_names = objects.data();
        settings.object_name_count = 3;
    }

    void name_two() {
        settings.aovs = "cryptomatte";
        settings.object_names = objects.data();
        settings.object_name_count = 2;
        settings.material_names = materials.data();
        settings.material_name_count = 1;
    }

    std::vector<const char*> objects = {"bunny", "a \"b\""}, materials = {"default"};
};

/// A scene's grass may be hundreds of objects: one name in a picture is one id.
TEST_F(AbiCryptomatte, ObjectsOfOneNameCountTogether) {
    name_three_of_two_names();
    const Frame made = of_eight_passes([](int, int, std::uint32_t pass) {
        const std::uint32_t objects_met[] = {2, 2, 2, 3, 3, 1, 1, 1};
        return std::pair(objects_met[pass], 1u);
    });
    expect_two(made, "bunny", 0.625f, "a \"b\"", 0.375f);
}

TEST_F(AbiCryptomatte, CoverageIsTheShareOfSamplesTheLargestFirst) {
    name_two();
    // Object 2 in five samples, object 1 in two, one misses; in pixel 0, 0 eight objects of a sample each.
    const Frame made = of_eight_passes([](int x, int y, std::uint32_t pass) {
        if (x == 0 && y == 0)
            return std::pair(8 - pass, pass < 4 ? 1u : 7u);
        return std::pair(pass < 2 ? 1u : pass < 7 ? 2u : 0u, pass < 7 ? 1u : 0u);
    });
    expect_two(made, "a \"b\"", 0.625f, "bunny", 0.25f);
    EXPECT_EQ(made.planes.at("crypto_material").pixel(40, 20)[0], cryptomatte_id("default"));
    EXPECT_EQ(made.planes.at("crypto_material").pixel(40, 20)[1], 0.875f);
    // Six are kept; those without a name are called after their number. Of equal shares the lowest number comes first.
    const float* crowded = made.planes.at("crypto_object").pixel(0, 0);
    for (int rank = 0; rank < 6; ++rank) {
        EXPECT_EQ(crowded[2 * rank], cryptomatte_id("object " + std::to_string(rank + 3))) << rank;
        EXPECT_EQ(crowded[2 * rank + 1], 0.125f);
    }
    EXPECT_EQ(made.planes.at("crypto_material").pixel(0, 0)[2], cryptomatte_id("material 7"));
}

/// As other programs see it, by OpenImageIO: channels of single precision, and what they mean.
TEST_F(AbiCryptomatte, FilesSayWhatTheSpecificationAsksFor) {
    name_two();
    for (const bool single_part : {false, true}) {
        settings.single_part = single_part;
        settings.overwrite = 1;
        es_sequence* sequence = open();
        es_frame* frame = begin(sequence, at(0));
        fill(
            frame, [](int, int, std::uint32_t) { return std::pair(1u, 1u); }, 4);
        end(frame);
        es_sequence_close(sequence);
        const auto file = OIIO::ImageInput::open(output + "/" + frame_file_name(0));
        ASSERT_TRUE(file);
        const OIIO::ImageSpec spec = file->spec(single_part ? 0 : 1);
        for (const char* type : {"CryptoObject", "CryptoMaterial"})
            for (const char* layer : {"00", "01", "02"})
                for (const char* channel : {".r", ".g", ".b", ".a"}) {
                    const int index = spec.channelindex(std::string(type) + layer + channel);
                    ASSERT_GE(index, 0) << type << layer << channel;
                    EXPECT_EQ(spec.channelformat(index), OIIO::TypeFloat);
                }
        for (const int part : {0, single_part ? 0 : 1}) {
            const OIIO::ImageSpec said = file->spec(part);
            EXPECT_EQ(said.get_string_attribute("cryptomatte/3ae39a5/name"), "CryptoObject");
            EXPECT_EQ(said.get_string_attribute("cryptomatte/3ae39a5/hash"), "MurmurHash3_32");
            EXPECT_EQ(said.get_string_attribute("cryptomatte/3ae39a5/conversion"), "uint32_to_float32");
            EXPECT_EQ(said.get_string_attribute("cryptomatte/be359d6/name"), "CryptoMaterial");
            EXPECT_EQ(said.get_string_attribute("cryptomatte/be359d6/manifest"), R"({"default":"42c9679f"})");
            char id[9];
            std::snprintf(id, sizeof id, "%08x", std::bit_cast<std::uint32_t>(cryptomatte_id("a \"b\"")));
            EXPECT_EQ(said.get_string_attribute("cryptomatte/3ae39a5/manifest"),
                      R"({"bunny":"13851a76","a \"b\"":")" + std::string(id) + "\"}");
        }
    }
}

TEST_F(AbiCryptomatte, AFrameWithoutAllIdsIsNotFinished) {
    name_two();
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    fill(
        frame, [](int, int, std::uint32_t) { return std::pair(1u, 1u); }, 3);
    es_error error{};
    EXPECT_EQ(es_frame_end(frame, &error), ES_BAD_INPUT);
    EXPECT_NE(std::string(error.text).find("plane crypto_object unfinished in 6 of 6 tiles"), std::string::npos);
    frame = begin(sequence, at(1));
    fill(
        frame, [](int, int, std::uint32_t) { return std::pair(1u, 1u); }, 4);
    EXPECT_EQ(es_frame_end(frame, &error), ES_OK) << error.text;
    es_sequence_close(sequence);
    settings.aovs = "none";
    settings.overwrite = 1;
    sequence = open();
    frame = begin(sequence, at(0));
    fill(
        frame, [](int, int, std::uint32_t) { return std::pair(1u, 1u); }, 4);  // taken by nobody, and no misuse
    end(frame);
    es_sequence_close(sequence);
}

TEST_F(AbiCryptomatte, PartsPutTogetherAreTheWholeFrame) {
    name_two();
    const Met met = [](int x, int y, std::uint32_t pass) {
        return std::pair((x * 7 + y * 3 + pass) % 4u, (x + pass) % 3u);
    };
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    fill(frame, met, 4);
    end(frame);
    es_sequence_close(sequence);
    const Frame whole = read(0);
    output += "/parts";
    settings.output_dir = output.c_str();
    settings.part_count = 2;
    for (const std::uint32_t part : {1u, 2u, 0u}) {
        settings.part = part;
        sequence = open();
        frame = begin(sequence, at(0));
        if (part > 0)
            fill(frame, met, 4);
        end(frame);
        es_sequence_close(sequence);
    }
    for (const char* plane : {"crypto_object", "crypto_material"})
        EXPECT_TRUE(std::ranges::equal(whole.planes.at(plane).samples(), read(0).planes.at(plane).samples())) << plane;
}

TEST_F(AbiCryptomatte, NamesAreChecked) {
    name_two();
    objects[1] = "\xff";
    EXPECT_NE(refusal().find("object_names: expected UTF-8"), std::string::npos);
    settings.object_names = nullptr;
    EXPECT_NE(refusal().find("object_names: expected a pointer"), std::string::npos);
    name_two();
    objects[1] = nullptr;  // counts as an empty name
    settings.layer = ES_LAYER_HIDDEN;
    EXPECT_NE(refusal().find("no cryptomatte in a hidden layer"), std::string::npos);
}

}  // namespace
}  // namespace equistream::testing
