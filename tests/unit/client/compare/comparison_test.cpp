#include <client/compare/comparison_report.h>
#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include <unistd.h>

namespace equistream {
namespace {

namespace fs = std::filesystem;

class Comparison : public ::testing::Test {
protected:
    void SetUp() override {
        root_ = fs::temp_directory_path() / ("equistream_comparison_" + std::to_string(getpid()));
        fs::remove_all(root_);
        fs::create_directories(root_);
    }
    void TearDown() override { fs::remove_all(root_); }

    fs::path make_png(const std::string& name, std::uint8_t value, int width = 48, int height = 32) {
        const ByteImage picture(width, height, 3, value);
        write_picture(root_ / name, picture.view());
        return root_ / name;
    }
    fs::path make_exr(const std::string& name, float radiance, double exposure) {
        Frame frame;
        frame.info.camera = PerspectiveCamera{48, 32, 1.5};
        frame.info.exposure = exposure;
        frame.planes["colour"] = FloatImage(48, 32, 4, radiance);
        write_exr(root_ / name, frame);
        return root_ / name;
    }
    /// As a renderer leaves it: seed and samples are what the frame says, `noise` is what is in it.
    fs::path make_noisy(const std::string& name, std::uint64_t seed, std::uint32_t samples, unsigned noise) {
        Frame frame;
        frame.info.camera = PerspectiveCamera{48, 32, 1.5};
        frame.info.seed = seed;
        frame.info.samples_per_pixel = samples;
        FloatImage colour(48, 32, 4, 1);
        std::mt19937 generator(noise);
        for (float& value : colour.samples())
            value = static_cast<float>(generator() % 1024) / 1024;
        frame.planes["colour"] = std::move(colour);
        write_exr(root_ / name, frame);
        return root_ / name;
    }
    static EyePairs pair_of(const fs::path& picture, const fs::path& truth) {
        return {"view", {{std::nullopt, picture, truth, {}, {}, {}}}};
    }
    static std::string error_of(const EyePairs& pairs, const ComparisonOptions& options = {}) {
        try {
            compare_eye(pairs, options);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }

    fs::path root_;
};

TEST_F(Comparison, ExrGetsItsOwnExposureAndTheDisplayTransform) {
    // 0.5 x 0.25 is 0.1250 in linear light: sRGB 0.38857, code 99.
    const EyeScore score = compare_eye(pair_of(make_exr("a.exr", 0.5f, 0.25), make_png("t.png", 99)), {});
    EXPECT_EQ(score.pooled.error.sum, 0);
    ComparisonOptions other;
    other.exposure = 1;  // sRGB of 0.5 is 0.73536, code 188
    EXPECT_NEAR(compare_eye(pair_of(root_ / "a.exr", root_ / "t.png"), other).pooled.error.psnr_db(),
                20 * std::log10(255.0 / (188 - 99)), 1e-9);
}

TEST_F(Comparison, NoiseFreeErrorIsTakenOnBothScales) {
    EyePairs pairs = pair_of(make_exr("a.exr", 0.5f, 1), make_exr("t.exr", 0.25f, 1));
    pairs.pairs[0].second_picture = make_exr("a2.exr", 0.5f, 1);
    pairs.pairs[0].second_truth = make_exr("t2.exr", 0.25f, 1);
    const EyeScore score = compare_eye(pairs, {});
    ASSERT_TRUE(score.noise_free_linear && score.noise_free_display);
    EXPECT_NEAR(score.noise_free_linear->mean_square, 0.0625, 1e-6);
    EXPECT_NEAR(std::sqrt(score.noise_free_display->mean_square), 0.735357 - 0.537099, 1e-4);
    EXPECT_FALSE(score.noise_free_linear->only_bounded());
    const auto json = comparison_json({score}, {});
    EXPECT_NEAR(json["eyes"]["view"]["noise_free"]["linear"]["db"].get<double>(), 12.0412, 1e-3);
    EXPECT_NEAR(json["eyes"]["view"]["noise_free_worst_percent"]["linear"]["db"].get<double>(), 12.0412, 1e-3);
    EXPECT_EQ(json["eyes"]["view"]["noise_free_worst_percent"]["linear"]["samples"], 2 * 3 * 16) << "of 48x32 pixels";
    EXPECT_FALSE(score.gaps_noise_free_linear);
    pairs.pairs[0].gaps = make_png("gaps.png", 255);
    const auto with_gaps = comparison_json({compare_eye(pairs, {})}, {});
    EXPECT_NEAR(with_gaps["eyes"]["view"]["gaps"]["noise_free"]["linear"]["db"].get<double>(), 12.0412, 1e-3);
}

TEST_F(Comparison, RunsThatShareTheirNoiseHaveNoNoiseFreeError) {
    const auto second = [&](const fs::path& picture, const fs::path& truth) {
        EyePairs pairs = pair_of(root_ / "a.exr", root_ / "t.exr");
        pairs.pairs[0].second_picture = picture;
        pairs.pairs[0].second_truth = truth;
        return error_of(pairs);
    };
    const fs::path a = make_noisy("a.exr", 1, 64, 5);
    const fs::path t = make_noisy("t.exr", 1, 256, 6);
    const fs::path a2 = make_noisy("a2.exr", 2, 64, 7);
    const fs::path t2 = make_noisy("t2.exr", 2, 256, 8);
    EXPECT_EQ(second(a2, t2), "");
    const auto says = [](const std::string& error, const fs::path& file, const std::string& found) {
        return error.starts_with("--second: " + file.string() + ": ") && error.find(found) != std::string::npos;
    };
    EXPECT_TRUE(says(second(a, t2), a, "found the file " + a.string())) << second(a, t2);
    EXPECT_TRUE(says(second(a2, a), a, "found the file " + a.string())) << second(a2, a);
    fs::create_symlink(t, root_ / "alias.exr");
    EXPECT_TRUE(says(second(a2, root_ / "alias.exr"), root_ / "alias.exr", "found the file " + t.string()));
    const fs::path copy = make_noisy("copy.exr", 3, 256, 6);
    EXPECT_TRUE(says(second(a2, copy), copy, "found the contents of " + t.string())) << second(a2, copy);
    const fs::path same_seed = make_noisy("same_seed.exr", 1, 256, 9);
    EXPECT_TRUE(says(second(a2, same_seed), same_seed, "found seed 1")) << second(a2, same_seed);
    const fs::path fewer = make_noisy("fewer.exr", 2, 128, 9);
    EXPECT_TRUE(says(second(a2, fewer), fewer, "the 256 samples per pixel of")) << second(a2, fewer);
    EXPECT_EQ(second(make_noisy("foreign.exr", 1, 0, 10), t2), "") << "says nothing of its seed";
}

TEST_F(Comparison, SecondViewsAreCheckedByWhatPlaySaysOfTheirSource) {
    const auto views = [&](const std::string& name, int seed, int samples) {
        fs::create_directories(root_ / name / "left");
        std::ofstream(root_ / name / "report.json")
            << R"({"source": {"seed": )" << seed << R"(, "samples_per_pixel": )" << samples << "}}";
        return make_png(name + "/left/frame.0000.png", 9);
    };
    EyePairs pairs = pair_of(views("a", 1, 64), make_noisy("t.exr", 1, 256, 6));
    PicturePair& pair = pairs.pairs[0];
    pair.second_truth = make_noisy("t2.exr", 2, 256, 8);
    pair.second_picture = views("good", 2, 64);
    EXPECT_EQ(error_of(pairs), "");
    pair.second_picture = views("same_seed", 1, 64);
    EXPECT_NE(error_of(pairs).find("expected a run with another seed than the first, found seed 1"), std::string::npos);
    pair.second_picture = views("fewer", 2, 32);
    EXPECT_NE(error_of(pairs).find("expected the 64 samples per pixel of"), std::string::npos);
    std::ofstream(root_ / "fewer/report.json") << "[somebody else's";
    EXPECT_EQ(error_of(pairs), "");
}

TEST_F(Comparison, IdenticalPicturesSaySoInTableAndJson) {
    const fs::path picture = make_png("a.png", 7);
    const EyeScore score = compare_eye(pair_of(picture, picture), {});
    const auto json = comparison_json({score}, {});
    EXPECT_TRUE(json["eyes"]["view"]["psnr_db"].is_null());
    EXPECT_TRUE(json["eyes"]["view"]["identical"].get<bool>());
    EXPECT_NEAR(json["eyes"]["view"]["ssim"].get<double>(), 1, 1e-5);
    EXPECT_NE(comparison_table({score}, {}).find("identical"), std::string::npos);
}

TEST_F(Comparison, PicturesThatCannotBeComparedAreNamed) {
    const fs::path a = make_png("a.png", 1);
    const fs::path wide = make_png("wide.png", 1, 64, 32);
    const fs::path tiny = make_png("tiny.png", 1, 8, 8);
    EXPECT_NE(error_of(pair_of(wide, a)).find("wide.png: expected 48x32 pixels, found 64x32"), std::string::npos);
    EXPECT_NE(error_of(pair_of(tiny, tiny)).find("at least 11x11"), std::string::npos);
    EXPECT_NE(error_of(pair_of(a, root_ / "absent.png")).find("no such file"), std::string::npos);
    std::ofstream(root_ / "broken.png") << "not a picture";
    EXPECT_NE(error_of(pair_of(root_ / "broken.png", a)).find("broken.png"), std::string::npos);
    std::ofstream(root_ / "broken.exr") << "not a picture";
    EXPECT_NE(error_of(pair_of(root_ / "broken.exr", a)).find("broken.exr"), std::string::npos);
    fs::resize_file(wide, fs::file_size(wide) / 2);
    EXPECT_NE(error_of(pair_of(wide, a)).find("wide.png"), std::string::npos);
    ComparisonOptions sphere;
    sphere.sphere_psnr = true;
    EXPECT_NE(error_of(pair_of(a, make_exr("p.exr", 1, 1)), sphere).find("equirect"), std::string::npos);
}

TEST_F(Comparison, DifferencePicturesAreAmplified) {
    ComparisonOptions options;
    options.difference_folder = root_ / "difference";
    EyePairs pairs = pair_of(make_png("a.png", 10), make_png("t.png", 15));
    pairs.eye = "left";
    pairs.pairs[0].frame = 3;
    compare_eye(pairs, options);
    const ByteImage difference = read_picture(root_ / "difference/left/frame.0003.png");
    EXPECT_EQ(difference.pixel(0, 0)[0], 5 * difference_gain);
}

}  // namespace
}  // namespace equistream
