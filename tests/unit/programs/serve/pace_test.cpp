/// Samples a pixel that keep up with a rate, for machines on which a sphere takes a part of its own and a part a
/// sample.
#include <programs/serve/pace.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace equistream::serve {
namespace {

std::vector<std::uint32_t> run(Pace& pace, int spheres, double fixed_s, double sample_s) {
    std::vector<std::uint32_t> samples;
    for (int i = 0; i < spheres; ++i) {
        samples.push_back(pace.spp());
        pace.took(fixed_s + sample_s * pace.spp());
    }
    return samples;
}

TEST(Pace, RisesWhileThereIsTimeAndNoHigherThanTold) {
    Pace pace(12, 2);
    const auto samples = run(pace, 20, 0.01, 0.001);
    EXPECT_EQ(samples.front(), 1u);
    EXPECT_TRUE(std::ranges::is_sorted(samples));
    EXPECT_EQ(samples[2], 2u);
    EXPECT_EQ(samples.back(), 12u);
}

TEST(Pace, StaysWhereTheRateIsKept) {
    Pace pace(64, 2);
    const auto samples = run(pace, 400, 0.05, 0.07);
    EXPECT_EQ(samples.back(), 4u);  // 0.33 s of 0.5 s; eight take 0.61 s
    EXPECT_LE(std::ranges::max(samples), 4u);
}

TEST(Pace, HalvesAfterTwoSlowOnesAndIsSlowToTryAgain) {
    Pace pace(16, 2);
    run(pace, 20, 0.01, 0.001);
    EXPECT_EQ(pace.spp(), 16u);
    EXPECT_EQ(pace.took(0.6), Pace::Change::none);
    EXPECT_EQ(pace.took(0.1), Pace::Change::none);  // that was somebody else's doing
    EXPECT_EQ(pace.took(0.6), Pace::Change::none);
    EXPECT_EQ(pace.took(0.6), Pace::Change::fewer);
    EXPECT_EQ(pace.spp(), 8u);
    for (int i = 0; i < 7; ++i)
        pace.took(0.1);
    EXPECT_EQ(pace.spp(), 8u);
    pace.took(0.1);
    EXPECT_EQ(pace.spp(), 16u);
}

TEST(Pace, SaysOnceThatOneSampleIsTooSlow) {
    Pace pace(16, 2);
    int said = 0;
    for (int i = 0; i < 50; ++i)
        said += pace.took(0.9) == Pace::Change::cannot_keep_up ? 1 : 0;
    EXPECT_EQ(said, 1);
    EXPECT_EQ(pace.spp(), 1u);
}

}  // namespace
}  // namespace equistream::serve
