// Group "reference": a few pixels of the finished picture, sampled many times.
#include "abi_fixture.h"

#include <array>
#include <set>

namespace equistream::testing {
namespace {

class References : public AbiTest {
protected:
    void SetUp() override {
        AbiTest::SetUp();
        settings.aovs = "reference";
    }

    /// What a host was asked for beyond the picture's own tiles.
    struct Asked {
        std::size_t tiles = 0, geometry_rays = 0;
        std::set<std::uint64_t> seeds;  ///< of the picture's rays
        std::size_t shared_seeds = 0;   ///< rays of references that have one of those
        std::set<std::uint32_t> passes;
        std::array<glm::dvec3, 2> directions{};  ///< means over the rays of each half of a reference's passes
    };

    /// The picture is 1 everywhere, of references the first half of the passes is 0 and the second 1; `unanswered` of
    /// all are left out.
    Asked answer(es_frame* frame, std::uint32_t unanswered = 0) {
        Asked asked;
        es_tile tile{};
        std::vector<es_ray> rays;
        while (es_frame_next_tile(frame, &tile) == ES_OK) {
            const bool is_reference = tile.sample_count != settings.spp;
            rays.resize(tile.pixel_count);
            if (is_reference) {
                ++asked.tiles;
                asked.geometry_rays += es_tile_geometry_rays(frame, &tile, rays.data());
                asked.passes.insert(tile.sample_count);
            }
            for (std::uint32_t pass = 0; pass < tile.sample_count - (is_reference ? unanswered : 0); ++pass) {
                EXPECT_EQ(es_tile_colour_rays(frame, &tile, pass, rays.data()), tile.pixel_count);
                for (const es_ray& ray : rays)
                    if (is_reference)
                        asked.shared_seeds += asked.seeds.contains(ray.seed);
                    else
                        asked.seeds.insert(ray.seed);
                const bool is_second = 2 * pass >= tile.sample_count;
                for (const es_ray& ray : rays)
                    if (is_reference)
                        asked.directions[is_second] +=
                            glm::dvec3(ray.direction[0], ray.direction[1], ray.direction[2]) *
                            (2.0 / tile.sample_count / tile.pixel_count);
                const float level = is_reference ? float(is_second) : 1;
                const std::vector<float> rgba(std::size_t{tile.pixel_count} * 4, level);
                es_tile_put_radiance(frame, &tile, rgba.data());
            }
        }
        return asked;
    }
};

TEST_F(References, AreMeansOfManySamplesOfTheirOwn) {
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    const Asked asked = answer(frame);
    end(frame);
    es_sequence_close(sequence);
    EXPECT_EQ(asked.tiles, 1u);
    EXPECT_EQ(asked.passes, std::set<std::uint32_t>{256});
    EXPECT_EQ(asked.geometry_rays, 0u);
    EXPECT_EQ(asked.shared_seeds, 0u);
    const double pixel_rad = 2 * pi / settings.width;
    EXPECT_LT(glm::length(asked.directions[0] - asked.directions[1]), 0.02 * pixel_rad)
        << "both halves have to see all of their pixels";
    const Frame found = read(0);
    const FloatImage &reference = found.planes.at("reference"), &repeat = found.planes.at("reference_repeat");
    const FloatImage& colour = found.planes.at("colour");
    int known = 0;
    for (int y = 0; y < reference.height(); ++y)
        for (int x = 0; x < reference.width(); ++x) {
            EXPECT_EQ(colour.pixel(x, y)[0], 1);
            const float alpha = reference.pixel(x, y)[3];
            known += alpha == 1;
            EXPECT_EQ(reference.pixel(x, y)[1], 0);
            EXPECT_EQ(repeat.pixel(x, y)[1], alpha);
        }
    EXPECT_EQ(known, 16);
}

TEST_F(References, AreMissedWhereTheyAreUnfinished) {
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    answer(frame, 1);
    es_error error{};
    EXPECT_EQ(es_frame_end(frame, &error), ES_BAD_INPUT);
    EXPECT_STREQ(error.text, "frame 0: expected every plane finished, found plane colour unfinished in 1 of 7 tiles");
    es_sequence_close(sequence);
}

TEST_F(References, AreAllThatIsAskedForWherePlanesAreWhole) {
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    const std::vector<float> rgba(std::size_t(settings.width * settings.height) * 4, 1);
    es_plane plane{sizeof plane, "colour", ES_FLOAT32, 4, rgba.data(), std::size_t(settings.width) * 16};
    es_error error{};
    ASSERT_EQ(es_frame_put_plane(frame, &plane, &error), ES_OK) << error.text;
    const Asked asked = answer(frame);
    EXPECT_EQ(asked.tiles, 1u);
    EXPECT_TRUE(asked.seeds.empty());
    end(frame);
    frame = begin(sequence, at(1));
    ASSERT_EQ(es_frame_put_plane(frame, &plane, &error), ES_OK) << error.text;
    answer(frame);
    const es_tile foreign{0, 0, 0, 32, 32, 1024, 4};
    es_tile_put_radiance(frame, &foreign, rgba.data());
    EXPECT_EQ(es_frame_end(frame, &error), ES_BAD_INPUT);
    EXPECT_STREQ(error.text, "frame 1: es_tile_put_radiance: expected a tile of this frame, unchanged, found tile 0");
    es_sequence_close(sequence);
    const Frame found = read(0);
    float known = 0;
    for (int y = 0; y < settings.height; ++y)
        for (int x = 0; x < settings.width; ++x)
            if (found.planes.at("reference").pixel(x, y)[3] == 1) {
                ++known;
                EXPECT_EQ(found.planes.at("reference_repeat").pixel(x, y)[0], 1);
            }
    EXPECT_EQ(known, 16);
}

TEST_F(References, AreOfSurfacesThatAreSeenFirst) {
    settings.aovs = "depth,reference";
    settings.layer = ES_LAYER_HIDDEN;
    EXPECT_EQ(refusal(), "aovs: expected no reference in a hidden layer or an atlas of patches, found reference");
}

}  // namespace
}  // namespace equistream::testing
