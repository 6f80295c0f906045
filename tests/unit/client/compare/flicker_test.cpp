// Flicker beside closed forms: of noise, of what moves exactly, over a seam, behind what moved on; and of files.
#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>

#include <client/compare/comparison_report.h>
#include <client/compare/flicker.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace equistream {
namespace {

constexpr int width = 192;
constexpr int height = 96;

ScoredPicture moving(const Camera& camera, float across, float down) {
    ScoredPicture truth;
    truth.linear = true;
    truth.info.emplace().camera = camera;
    truth.radiance = FloatImage(width, height, 3);
    truth.backward = truth.forward = FloatImage(width, height, 2);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            truth.backward.pixel(x, y)[0] = -across;
            truth.backward.pixel(x, y)[1] = -down;
            truth.forward.pixel(x, y)[0] = across;
            truth.forward.pixel(x, y)[1] = down;
        }
    return truth;
}

std::int64_t count(ImageView<const std::uint8_t> seen) {
    return std::count(seen.data, seen.data + width * height, 255);
}

FloatImage with_noise(float value, float deviation, std::mt19937& generator) {
    std::normal_distribution<float> noise(value, deviation);
    FloatImage made(width, height, 3);
    std::ranges::generate(made.samples(), [&] { return noise(generator); });
    return made;
}

TEST(Flicker, OfAStillPictureIsItsNoiseTwice) {
    const PastPixels past({}, {});
    EXPECT_FALSE(past.by_motion());
    constexpr float bias = 0.1f, own = 0.05f, of_truth = 0.2f;
    std::mt19937 generator(43);
    // Two pictures, two truths.
    const auto draw = [&] {
        return std::array{with_noise(0.4f + bias, own, generator), with_noise(0.4f + bias, own, generator),
                          with_noise(0.4f, of_truth, generator), with_noise(0.4f, of_truth, generator)};
    };
    ProductBlocks whole, noise_free;
    auto before = draw();
    for (int frame = 1; frame < 30; ++frame) {
        const auto now = draw();
        std::array<FloatImage, 4> change;
        for (std::size_t i = 0; i < change.size(); ++i)
            change[i] = past.change(now[i], before[i]);
        const auto& [a, a2, t, t2] = change;
        whole.add(product_blocks({a.view(), t.view()}, {a.view(), t2.view()}));
        noise_free.add(product_blocks({a.view(), t.view()}, {a2.view(), t2.view()}));
        before = now;
    }
    const UnbiasedError flicker = unbiased_error(whole);
    EXPECT_NEAR(flicker.mean_square, 2 * own * own, 0.05 * 2 * own * own);
    EXPECT_LT(flicker.high - flicker.low, 0.2 * 2 * own * own);
    EXPECT_TRUE(unbiased_error(noise_free).only_bounded()) << "the error stays, and noise counts nothing";
}

TEST(Flicker, WhatMovesExactlyDoesNotFlicker) {
    const auto ramp = [](float shift) {
        FloatImage made(width, height, 3);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                std::fill_n(made.pixel(x, y), 3, (static_cast<float>(x) - shift + 2 * static_cast<float>(y)) / 512);
        return made;
    };
    const ScoredPicture truth = moving(PerspectiveCamera{width, height, 1.5}, 2.5f, 0);
    const PastPixels past(truth, truth);
    ASSERT_TRUE(past.by_motion());
    EXPECT_EQ(count(past.seen()), (width - 2) * height) << "two columns and a half come into view, one of them in part";
    const FloatImage change = past.change(ramp(2.5f), ramp(0));
    for (int y = 0; y < height; ++y)
        for (int x = 3; x < width; ++x)
            ASSERT_NEAR(*change.pixel(x, y), 0, 1e-6) << x << ", " << y;
    EXPECT_GT(*PastPixels({}, {}).change(ramp(2.5f), ramp(0)).pixel(9, 9) * -512, 2.4) << "unless motion is left out";
    const ScoredPicture falling = moving(PerspectiveCamera{width, height, 1.5}, 0, 2.5f);
    const PastPixels above(falling, falling);
    EXPECT_EQ(count(above.seen()), width * (height - 2));
    const FloatImage fallen = above.change(ramp(5), ramp(0));  // two and a half rows down
    for (int y = 3; y < height; ++y)
        for (int x = 0; x < width; ++x)
            ASSERT_NEAR(*fallen.pixel(x, y), 0, 1e-6) << x << ", " << y;
}

TEST(Flicker, ASphereGoesRound) {
    const auto stripes = [](int shift) {
        FloatImage made(width, height, 3);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                std::fill_n(made.pixel(x, y), 3, static_cast<float>((x - shift + width) % width) / width);
        return made;
    };
    const ScoredPicture truth = moving(EquirectCamera{width, height, {}}, 3, 0);
    const PastPixels past(truth, truth);
    EXPECT_EQ(count(past.seen()), width * height);
    const FloatImage change = past.change(stripes(3), stripes(0));
    for (const float changed : change.samples())
        ASSERT_NEAR(changed, 0, 1e-6);
}

TEST(Flicker, WhatWasHiddenIsLeftOut) {
    const ScoredPicture truth = moving(PerspectiveCamera{width, height, 1.5}, 0, 0);
    ScoredPicture before = truth;
    for (int y = 10; y < 20; ++y)
        for (int x = 30; x < 70; ++x)
            before.forward.pixel(x, y)[0] = 5;  // a nearer thing that has moved on
    const PastPixels past(truth, before);
    EXPECT_EQ(count(past.seen()), width * height - 10 * 40);
    EXPECT_EQ(*past.seen().pixel(30, 10), 0);
    EXPECT_EQ(*past.change(FloatImage(width, height, 3, 1.f), FloatImage(width, height, 3)).pixel(30, 10), 0);
}

namespace fs = std::filesystem;

class FlickerOfFiles : public ::testing::Test {
protected:
    void SetUp() override {
        root_ = fs::temp_directory_path() / ("equistream_flicker_" + std::to_string(getpid()));
        fs::remove_all(root_);
        for (const char* folder : {"a", "t", "t2"})
            fs::create_directories(root_ / folder);
        options_.whole = options_.flicker = true;
    }
    void TearDown() override { fs::remove_all(root_); }

    fs::path png(const std::string& folder, int frame, std::uint8_t value) const {
        const fs::path file = root_ / folder / frame_file_name(frame, "png");
        write_picture(file, ByteImage(48, 32, 3, value).view());
        return file;
    }
    void add_grey(int frame, std::uint8_t value) {
        pairs_.pairs.push_back({frame, png("a", frame, value), png("t", frame, 100), {}, png("t2", frame, 100), {}});
    }

    /// Things go three columns to the right a frame; every other column of them is brighter by `error`.
    fs::path exr(const std::string& folder, int frame, float error, bool with_motion) const {
        Frame made;
        made.info.camera = PerspectiveCamera{48, 32, 1.5};
        FloatImage colour(48, 32, 4, 0.5f);
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 48; ++x)
                std::fill_n(colour.pixel(x, y), 3, 0.5f + ((x - 3 * frame) % 2 == 0 ? error : 0.f));
        made.planes["colour"] = std::move(colour);
        if (with_motion)
            for (const auto& [plane, across] : {std::pair{"backward", -3.f}, {"forward", 3.f}}) {
                FloatImage motion(48, 32, 2);
                for (std::size_t i = 0; i < motion.samples().size(); i += 2)
                    motion.samples()[i] = across;
                made.planes[plane] = std::move(motion);
            }
        const fs::path file = root_ / folder / frame_file_name(frame, "exr");
        write_exr(file, made);
        return file;
    }
    void add_moving(int frame, bool with_motion) {
        pairs_.pairs.push_back(
            {frame, exr("a", frame, 0.1f, false), exr("t", frame, 0, with_motion), {}, exr("t2", frame, 0, false), {}});
    }

    nlohmann::ordered_json flicker() const {
        return comparison_json({compare_eye(pairs_, options_)}, options_)["eyes"]["view"]["flicker"];
    }
    std::string table() const { return comparison_table({compare_eye(pairs_, options_)}, options_); }

    fs::path root_;
    ComparisonOptions options_;
    EyePairs pairs_{"view", {}};
};

TEST_F(FlickerOfFiles, IsOfFramesThatFollowEachOther) {
    add_grey(3, 110);
    EXPECT_TRUE(flicker().is_null()) << "of one frame";
    add_grey(5, 120);
    EXPECT_TRUE(flicker().is_null()) << "frame 4 is missing";
    add_grey(6, 100);
    EXPECT_EQ(flicker()["motion"], "none");
    const double square = std::pow(20 / 255.0, 2);
    EXPECT_NEAR(flicker()["whole"]["display"]["mean_square"].get<double>(), square, 1e-7);
    add_grey(7, 100);
    EXPECT_NEAR(flicker()["whole"]["display"]["mean_square"].get<double>(), square / 2, 1e-7);
    EXPECT_NE(table().find("the truth has no motion"), std::string::npos);
}

TEST_F(FlickerOfFiles, GoesAlongTheTruthsMotion) {
    add_moving(0, true), add_moving(1, true);
    EXPECT_EQ(flicker()["motion"], "exact");
    EXPECT_EQ(flicker()["whole"]["linear"]["mean_square"], 0);
    EXPECT_EQ(flicker()["whole"]["linear"]["samples"], 3 * 45 * 32) << "three columns have come into view";
    EXPECT_NE(table().find("along the truth's motion"), std::string::npos);
    pairs_.pairs.clear();
    add_moving(0, false), add_moving(1, false);
    EXPECT_EQ(flicker()["motion"], "none");
    EXPECT_NEAR(flicker()["whole"]["linear"]["mean_square"].get<double>(), 0.01, 1e-4) << "of halves";
    add_moving(2, true), add_moving(3, true);
    try {
        flicker();
        ADD_FAILURE() << "a mixture was scored";
    } catch (const InputError& error) {
        EXPECT_EQ(error.what(), (root_ / "t/frame.0003.exr").string() +
                                    ": expected motion AOVs in all frames or in none, " +
                                    "found some, and none in the frames before");
    }
}

}  // namespace
}  // namespace equistream
