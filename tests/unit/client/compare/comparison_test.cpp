#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>

#include <client/compare/compared_pictures.h>
#include <client/compare/comparison_report.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <fstream>
#include <random>

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
    ASSERT_TRUE(score.noise_free.all);
    EXPECT_NEAR(score.noise_free.all->linear.mean_square, 0.0625, 1e-6);
    EXPECT_NEAR(std::sqrt(score.noise_free.all->display.mean_square), 0.735357 - 0.537099, 1e-4);
    EXPECT_FALSE(score.noise_free.all->linear.only_bounded());
    EXPECT_FALSE(score.whole.all) << "A may share noise with TRUTH: it is to be asked for";
    const auto json = comparison_json({score}, {});
    EXPECT_NEAR(json["eyes"]["view"]["noise_free"]["linear"]["db"].get<double>(), 12.0412, 1e-3);
    EXPECT_NEAR(json["eyes"]["view"]["noise_free_worst_percent"]["linear"]["db"].get<double>(), 12.0412, 1e-3);
    EXPECT_EQ(json["eyes"]["view"]["noise_free_worst_percent"]["linear"]["samples"], 2 * 3 * 16) << "of 48x32 pixels";
    EXPECT_FALSE(score.noise_free.gaps);
    pairs.pairs[0].gaps = make_png("gaps.png", 255);
    const auto with_gaps = comparison_json({compare_eye(pairs, {})}, {});
    EXPECT_NEAR(with_gaps["eyes"]["view"]["gaps"]["noise_free"]["linear"]["db"].get<double>(), 12.0412, 1e-3);
}

/// A plain sky holds no noise that two renders could share.
TEST_F(Comparison, PicturesOfOneColourMayBeAlike) {
    const auto make_sky = [&](const char* name, std::uint64_t seed) {
        Frame frame;
        frame.info.camera = PerspectiveCamera{48, 32, 1.5};
        frame.info.seed = seed;
        FloatImage colour(48, 32, 4);
        for (int i = 0; i < 48 * 32; ++i)
            std::ranges::copy(std::array{0.1f, 0.2f, 0.3f, 1.0f}, colour.pixel(i % 48, i / 48));
        frame.planes["colour"] = std::move(colour);
        write_exr(root_ / name, frame);
        return root_ / name;
    };
    EyePairs pairs = pair_of(make_sky("a.exr", 1), make_sky("t.exr", 2));
    pairs.pairs[0].second_picture = make_sky("a2.exr", 3);
    pairs.pairs[0].second_truth = make_sky("t2.exr", 4);
    EXPECT_EQ(error_of(pairs), "");
}

/// All at once they would take more memory than there is.
TEST_F(Comparison, LargePairsAreWorkedOnOneAfterTheOther) {
    EyePairs pairs = pair_of(make_png("a.png", 10), make_png("t.png", 15));
    pairs.pairs.assign(8, PicturePair(pairs.pairs.front()));
    pairs.pairs[4].picture = root_ / "none.png";  // where a second thread would begin
    ComparisonOptions options;
    options.bytes_at_once = 1;
    std::atomic<int> done = 0;
    EXPECT_THROW(compare_eye(pairs, options, [&] { ++done; }), InputError);
    EXPECT_EQ(done.load(), 4) << "those before it, and no other";
}

TEST_F(Comparison, FramesAreAddedInTheirOrderHoweverManyAreWorkedOn) {
    EyePairs pairs{"view", {}};
    for (unsigned frame = 0; frame < 12; ++frame) {
        const std::string name = std::to_string(frame) + ".exr";
        pairs.pairs.push_back(
            {frame, make_noisy("a" + name, 1, 64, frame), make_noisy("t" + name, 2, 64, 99 - frame), {}, {}, {}});
    }
    for (const std::int64_t bytes_at_once : {std::int64_t{1}, ComparisonOptions().bytes_at_once}) {
        ComparisonOptions options;
        options.bytes_at_once = bytes_at_once;
        const EyeScore score = compare_eye(pairs, options);
        ASSERT_EQ(score.frames.size(), pairs.pairs.size());
        double sum = 0;  // whose last bits depend on the order
        for (std::size_t i = 0; i < score.frames.size(); ++i) {
            EXPECT_EQ(score.frames[i].frame, pairs.pairs[i].frame);
            sum += score.frames[i].similarity.all.sum;
        }
        EXPECT_EQ(score.pooled.similarity.all.sum, sum);
    }
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

TEST_F(Comparison, WholeErrorIsTakenOnBothScalesWhereverTheNoiseFreeOneIs) {
    EyePairs pairs = pair_of(make_exr("a.exr", 0.5f, 1), make_exr("t.exr", 0.25f, 1));
    pairs.pairs[0].second_truth = make_exr("t2.exr", 0.25f, 1);
    pairs.pairs[0].gaps = make_png("gaps.png", 255);
    ComparisonOptions options;
    options.whole = true;
    const EyeScore score = compare_eye(pairs, options);
    const auto eye = comparison_json({score}, options)["eyes"]["view"];
    for (const auto& figures : {eye["whole"], eye["whole_worst_percent"], eye["gaps"]["whole"]}) {
        EXPECT_NEAR(figures["linear"]["mean_square"].get<double>(), 0.0625, 1e-6);
        EXPECT_NEAR(std::sqrt(figures["display"]["mean_square"].get<double>()), 0.735357 - 0.537099, 1e-4);
    }
    EXPECT_FALSE(eye.contains("noise_free"));
    EXPECT_NE(comparison_table({score}, options).find("whole, linear"), std::string::npos);
    pairs.pairs[0].second_picture = make_exr("a2.exr", 0.75f, 1);
    const EyeScore both = compare_eye(pairs, options);
    EXPECT_NEAR(both.whole.all->linear.mean_square, 0.0625, 1e-6) << "of A alone";
    EXPECT_NEAR(both.noise_free.all->linear.mean_square, 0.25 * 0.5, 1e-6) << "of both runs";
}

TEST_F(Comparison, TruthsThatShareNoiseWithAnythingHaveNoWholeError) {
    ComparisonOptions options;
    options.whole = true;
    const auto error = [&](const fs::path& picture, const fs::path& truth2) {
        EyePairs pairs = pair_of(picture, root_ / "t.exr");
        pairs.pairs[0].second_truth = truth2;
        return error_of(pairs, options);
    };
    const fs::path a = make_noisy("a.exr", 1, 64, 5);
    const fs::path t = make_noisy("t.exr", 21, 256, 6);
    const fs::path t2 = make_noisy("t2.exr", 22, 256, 8);
    EXPECT_EQ(error(a, t2), "");
    const auto refusal = [](const fs::path& file, const std::string& expected, const std::string& found) {
        return "--truth2: " + file.string() + ": expected " + expected + ", found " + found;
    };
    const std::string own = "noise of its own";
    EXPECT_EQ(error(a, t), refusal(t, own, "the file " + t.string()));
    fs::copy_file(t, root_ / "copy.exr");
    EXPECT_EQ(error(a, root_ / "copy.exr"), refusal(root_ / "copy.exr", own, "the contents of " + t.string()));
    const fs::path same_seed = make_noisy("same_seed.exr", 21, 256, 9);
    EXPECT_EQ(error(a, same_seed), refusal(same_seed, own, "seed 21, that of " + t.string()));
    for (const fs::path& truth : {t, t2}) {
        const fs::path of_it = make_noisy("of_" + truth.filename().string(), truth == t ? 21 : 22, 64, 10);
        const std::string seed = truth == t ? "21" : "22";
        EXPECT_EQ(error(of_it, t2), refusal(of_it, own, "seed " + seed + ", that of " + truth.string()));
    }
    const fs::path fewer = make_noisy("fewer.exr", 22, 128, 9);
    EXPECT_EQ(error(a, fewer), refusal(fewer, "the 256 samples per pixel of " + t.string(), "128"));
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
    EXPECT_NE(error_of(pairs).find("expected noise of its own, found seed 1"), std::string::npos);
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

TEST_F(Comparison, DifferencePicturesReplaceEarlierOnesAlone) {
    fs::create_directories(root_ / "views/left");
    const fs::path view = make_png("views/left/frame.0003.png", 7);
    EyePairs pairs = pair_of(make_png("a.png", 10), make_png("t.png", 15));
    pairs.eye = "left";
    pairs.pairs[0].frame = 3;
    ComparisonOptions options;
    for (int i = 0; i < 2; ++i) {
        options.difference_folder = root_ / "difference";
        EXPECT_EQ(error_of(pairs, options), "");
    }
    options.difference_folder = root_ / "views";
    EXPECT_EQ(error_of(pairs, options),
              "--difference " + (root_ / "views").string() +
                  ": expected a new folder, or one with differences.json, which says that "
                  "its pictures are differences, found a folder without it; remove it or choose another name");
    EXPECT_EQ(read_picture(view).pixel(0, 0)[0], 7);
}

TEST_F(Comparison, DifferencePicturesTakeNoComparedOnesPlaces) {
    fs::create_directories(root_ / "a/left"), fs::create_directories(root_ / "t/left");
    EyePairs pairs = pair_of(make_png("a/left/frame.0003.png", 10), make_png("t/left/frame.0003.png", 15));
    pairs.eye = "left";
    pairs.pairs[0].frame = 3;
    fs::create_directory_symlink(root_ / "t", root_ / "link");
    ComparisonOptions options;
    for (const char* folder : {"a", "t", "link"}) {
        options.difference_folder = root_ / folder;
        EXPECT_NE(error_of(pairs, options).find("a folder apart from what is compared"), std::string::npos) << folder;
    }
    EXPECT_EQ(read_picture(pairs.pairs[0].picture).pixel(0, 0)[0], 10);
    EXPECT_EQ(read_picture(pairs.pairs[0].truth).pixel(0, 0)[0], 15);
    options.difference_folder = root_;
    EXPECT_EQ(error_of(pair_of(make_png("a.png", 10), make_png("t.png", 15)), options), "") << "files have other names";
}

}  // namespace

namespace {

namespace fs = std::filesystem;

class PicturePairs : public ::testing::Test {
protected:
    void SetUp() override {
        root_ = fs::temp_directory_path() / ("equistream_pairs_" + std::to_string(getpid()));
        fs::remove_all(root_);
    }
    void TearDown() override { fs::remove_all(root_); }

    void make_frames(const std::string& folder, int count, const std::string& extension = "png") {
        fs::create_directories(root_ / folder);
        for (int i = 0; i < count; ++i)
            std::ofstream(root_ / folder / frame_file_name(i, extension)).put('\n');
    }
    PairingOptions options(const std::string& a, const std::string& truth) {
        PairingOptions pairing;
        pairing.picture = root_ / a;
        pairing.truth = root_ / truth;
        return pairing;
    }
    static std::string error_of(const PairingOptions& pairing) {
        try {
            pair_pictures(pairing);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }

    fs::path root_;
};

TEST_F(PicturePairs, LeftAndRightArePairedApart) {
    make_frames("a/left", 3), make_frames("a/right", 3);
    make_frames("t/left", 3, "exr"), make_frames("t/right", 3, "exr");
    const auto eyes = pair_pictures(options("a", "t"));
    ASSERT_EQ(eyes.size(), 2u);
    EXPECT_EQ(eyes[0].eye, "left");
    EXPECT_EQ(eyes[1].eye, "right");
    ASSERT_EQ(eyes[1].pairs.size(), 3u);
    EXPECT_EQ(eyes[1].pairs[2].picture, root_ / "a/right/frame.0002.png");
    EXPECT_EQ(eyes[1].pairs[2].truth, root_ / "t/right/frame.0002.exr");
    EXPECT_EQ(eyes[1].pairs[2].frame, 2);
}

TEST_F(PicturePairs, BareFoldersAndFilesAreOneView) {
    make_frames("a", 2), make_frames("t", 2);
    EXPECT_EQ(pair_pictures(options("a", "t")).at(0).eye, "view");
    const auto files = pair_pictures(options("a/frame.0000.png", "t/frame.0001.png"));
    ASSERT_EQ(files.at(0).pairs.size(), 1u);
    EXPECT_FALSE(files[0].pairs[0].frame.has_value());
    EXPECT_NE(error_of(options("a/frame.0000.png", "t")).find("only files or only folders"), std::string::npos);
}

TEST_F(PicturePairs, SecondRunAndGapsFollowTheFrames) {
    for (const char* folder : {"a/left", "t/left", "a2/left", "t2/left", "g/left"})
        make_frames(folder, 2);
    PairingOptions pairing = options("a", "t");
    pairing.second_picture = root_ / "a2";
    pairing.second_truth = root_ / "t2";
    pairing.gaps = root_ / "g";
    const PicturePair pair = pair_pictures(pairing).at(0).pairs.at(1);
    EXPECT_EQ(pair.second_picture, root_ / "a2/left/frame.0001.png");
    EXPECT_EQ(pair.second_truth, root_ / "t2/left/frame.0001.png");
    EXPECT_EQ(pair.gaps, root_ / "g/left/frame.0001.png");
}

TEST_F(PicturePairs, FrameRangeSelects) {
    make_frames("a", 5), make_frames("t", 4);
    PairingOptions pairing = options("a", "t");
    EXPECT_NE(error_of(pairing).find("t/frame.0004.png: expected a frame to compare"), std::string::npos);
    pairing.first_frame = 1;
    pairing.last_frame = 3;
    EXPECT_EQ(pair_pictures(pairing).at(0).pairs.size(), 3u);
    pairing.last_frame = 4;
    EXPECT_NE(error_of(pairing), "");
    pairing.last_frame = std::int64_t{1} << 60;  // more than any memory holds
    EXPECT_NE(error_of(pairing).find("frame.0004.png: expected a frame to compare"), std::string::npos);
}

TEST_F(PicturePairs, WhatIsMissingIsNamed) {
    make_frames("a/left", 1), make_frames("a/right", 1), make_frames("t/left", 1);
    EXPECT_NE(error_of(options("a", "t")).find("t/right: expected"), std::string::npos);
    EXPECT_NE(error_of(options("nowhere", "t/left")).find("nowhere: expected"), std::string::npos);
    fs::create_directories(root_ / "empty");
    EXPECT_NE(error_of(options("empty", "empty")).find("found no frame"), std::string::npos);
    make_frames("both", 1, "png"), make_frames("both", 1, "exr");
    EXPECT_NE(error_of(options("both", "both")).find("frames of one format"), std::string::npos);
    PairingOptions pairing = options("a", "t");
    pairing.eyes = {"middle"};
    EXPECT_NE(error_of(pairing).find("left, right, centre or small"), std::string::npos);
    pairing.eyes = {"left"};
    EXPECT_EQ(pair_pictures(pairing).size(), 1u);
}

TEST_F(PicturePairs, SingleFilesHaveNoFramesToChooseFrom) {
    make_frames("a", 2), make_frames("t", 2);
    PairingOptions pairing = options("a/frame.0000.png", "t/frame.0001.png");
    pairing.first_frame = pairing.last_frame = 1;
    EXPECT_EQ(error_of(pairing), "--frames: expected folders of frames to choose from, found the single file " +
                                     (root_ / "a/frame.0000.png").string());
}

TEST_F(PicturePairs, MoreFramesInTheTruthNeedARange) {
    make_frames("a", 2), make_frames("t", 3);
    EXPECT_NE(error_of(options("a", "t")).find("found 3 frames"), std::string::npos);
}

/// 188 is 0.502886 in linear light.
TEST_F(Comparison, APngsLightIsThatOfItsCodes) {
    EyePairs pairs = pair_of(make_png("a.png", 188), make_exr("t.exr", 0.25f, 1));
    pairs.pairs[0].second_truth = make_exr("t2.exr", 0.25f, 1);
    ComparisonOptions options;
    options.whole = true;
    EXPECT_NEAR(std::sqrt(compare_eye(pairs, options).whole.all->linear.mean_square), 0.502886 - 0.25, 2e-4);
}

TEST(UnbiasedText, SaysWhatIsKnown) {
    EXPECT_EQ(unbiased_text({0.01, 0.001, 0.1, 1, 1}), "20.00 dB [10.00, 30.00]");
    EXPECT_EQ(unbiased_text({0.01, -1, 0.1, 1, 1}), "> 10.00 dB");
    EXPECT_EQ(unbiased_text({0, -0.1, 0.1, 1, 1}), "> 10.00 dB");
    EXPECT_EQ(unbiased_text({0, 0, 0, 1, 1}), "identical");
    EXPECT_EQ(unbiased_text({-1, -2, 0, 1, 1}), "none found");
}

}  // namespace
}  // namespace equistream
