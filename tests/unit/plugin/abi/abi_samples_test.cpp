/// How many samples tiles get, and what is done about the noise of few.
#include "abi_fixture.h"

#include <equistream/conventions.h>

#include <cmath>
#include <map>
#include <set>

namespace equistream::testing {
namespace {

class AbiSamples : public AbiTest {};

/// In proportion to the cosine of latitudes, by the mean of each of four rows of tiles.
TEST_F(AbiSamples, samples_by_angle_are_fewer_towards_the_poles) {
    settings.width = 64;
    settings.height = 32;
    settings.tile_side = 8;
    settings.spp = 16;
    settings.samples_by_angle = 1;
    settings.aovs = "none";
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    std::map<int, std::set<std::uint32_t>> counts;
    es_tile tile{};
    while (es_frame_next_tile(frame, &tile) == ES_OK)
        counts[tile.y].insert(tile.sample_count);
    es_frame_discard(frame);
    ASSERT_EQ(counts.size(), 4u);
    for (const auto& [y, of_row] : counts) {
        const double top = pi * y / 32, bottom = pi * (y + 8) / 32;
        const double mean_cosine = (std::cos(top) - std::cos(bottom)) / (bottom - top);
        for (const std::uint32_t samples : of_row)
            EXPECT_NEAR(samples, 16 * mean_cosine, 1.01) << y;
    }
    EXPECT_LT(*counts[0].rbegin(), *counts[8].begin());
    fill(frame = begin(sequence, at(1)), miss, black);
    end(frame);
    es_sequence_close(sequence);
    settings.samples_by_angle = 0;
    EXPECT_NE(refusal().find("expected fingerprint"), std::string::npos) << "another spread is another setting";
    settings.samples_by_angle = 1;
    settings.camera = ES_PERSPECTIVE;
    EXPECT_EQ(refusal(), "samples_by_angle: expected 0 in flat views, in an atlas of patches and where frames are "
                         "accumulated, found 1");
}

TEST_F(AbiSamples, what_is_denoised_keeps_its_raw_colour_and_loses_its_guides) {
    settings.aovs = "raw";
    settings.denoise = ES_DENOISE_FAST;
    es_sequence* sequence = nullptr;
    es_error error{};
    ASSERT_EQ(es_sequence_open(&settings, &sequence, &error), ES_OK)
        << error.text << "; tests/requirements.txt has the denoiser";
    const Radiance noisy = [](const es_ray& ray) {
        const float light = 0.5f + 0.4f * std::sin(1e4f * ray.direction[0] + 2e4f * ray.direction[1]);
        return glm::vec4(light, light, light, 1);
    };
    es_frame* frame = begin(sequence, at(0));
    es_tile tile{};
    std::vector<es_ray> rays;
    while (es_frame_next_tile(frame, &tile) == ES_OK) {
        rays.resize(tile.pixel_count);
        std::vector<float> rgba(tile.pixel_count * 4);
        const std::vector<float> guides(tile.pixel_count * 6, 0.5f);
        for (std::uint32_t pass = 0; pass < tile.sample_count; ++pass) {
            es_tile_colour_rays(frame, &tile, pass, rays.data());
            for (std::uint32_t i = 0; i < tile.pixel_count; ++i) {
                const glm::vec4 colour = noisy(rays[i]);
                std::copy(&colour.x, &colour.x + 4, &rgba[i * 4]);
            }
            es_tile_put_radiance(frame, &tile, rgba.data());
            es_tile_put_guides(frame, &tile, guides.data());
        }
    }
    end(frame);
    es_sequence_close(sequence);
    const Frame denoised = read(0);
    settings.denoise = ES_DENOISE_OFF;
    settings.aovs = "none";
    settings.overwrite = 1;
    sequence = open();
    frame = begin(sequence, at(0));
    fill(frame, miss, noisy);
    end(frame);
    es_sequence_close(sequence);
    const Frame plain = read(0);
    const auto sum_of_steps = [](const FloatImage& image) {
        double sum = 0;
        for (int y = 0; y < image.height(); ++y)
            for (int x = 1; x < image.width(); ++x)
                sum += std::abs(image.pixel(x, y)[0] - image.pixel(x - 1, y)[0]);
        return sum;
    };
    const FloatImage &raw = denoised.planes.at("raw"), &colour = denoised.planes.at("colour");
    for (int y = 0; y < raw.height(); ++y)
        for (int x = 0; x < raw.width(); ++x)
            ASSERT_EQ(raw.pixel(x, y)[0], plain.planes.at("colour").pixel(x, y)[0]);
    EXPECT_LT(sum_of_steps(colour), 0.5 * sum_of_steps(raw));
    EXPECT_EQ(denoised.planes.count("guide_albedo") + denoised.planes.count("guide_normal"), 0u);
    EXPECT_NE(denoised.info.denoiser, "");
    EXPECT_EQ(plain.info.denoiser, "");
}

}  // namespace
}  // namespace equistream::testing
