// What users read is one line, whatever a file put into it.
#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <gtest/gtest.h>

#include <limits>

namespace equistream {
namespace {

TEST(ExpectedFound, SaysWhereWhatAndWhat) {
    EXPECT_EQ(expected_found("a.json:3", "a number", "\"north\""), "a.json:3: expected a number, found \"north\"");
}

TEST(ExpectedFound, StaysOneLine) {
    EXPECT_EQ(expected_found("a\nb", "\tone\r\nline", "two\nlines \x1b[2J\x7f"),
              "a?b: expected ?one??line, found two?lines ?[2J?");
    EXPECT_EQ(expected_found("a", "b", "caf\xc3\xa9"), "a: expected b, found caf\xc3\xa9");
}

TEST(ExpectedFound, CutsWhatNobodyReads) {
    const std::string line = expected_found("a", "b", std::string(1000000, 'x'));
    EXPECT_EQ(line, "a: expected b, found " + std::string(300, 'x') + "...");
    EXPECT_EQ(expected_found("a", "b", std::string(300, 'x')), "a: expected b, found " + std::string(300, 'x'));
}

}  // namespace

namespace {

using Words = std::vector<std::string_view>;

TEST(CommaList, OneMoreWordThanCommas) {
    EXPECT_EQ(split_at_commas("depth,motion"), (Words{"depth", "motion"}));
    EXPECT_EQ(split_at_commas("one"), Words{"one"});
    EXPECT_EQ(split_at_commas(""), Words{""});
    EXPECT_EQ(split_at_commas(",a,,"), (Words{"", "a", "", ""}));
}

TEST(CommaList, WordsAreTrimmedAndKeepSpacesWithin) {
    EXPECT_EQ(split_at_commas(" a , b c\t,\r"), (Words{"a", "b c", ""}));
    EXPECT_EQ(trimmed(" \t "), "");
}

}  // namespace

// One text decides which poses, IPDs and head boxes are taken; every reader of them goes by it.

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(PoseLimits, CoordinatesUpToTheLimitAreTaken) {
    EXPECT_FALSE(position_mismatch({1e9, -1e9, 0}));
    for (const double bad : {1.0000001e9, -1e19, inf, -inf, nan})
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 position(0);
            position[axis] = bad;
            EXPECT_TRUE(position_mismatch(position)) << bad << " on axis " << axis;
            EXPECT_FALSE(is_position(position));
        }
    const auto wrong = position_mismatch({0, 1e19, nan});
    ASSERT_TRUE(wrong);
    EXPECT_EQ(wrong->expected, "coordinates from -1e9 to 1e9 metres");
    EXPECT_EQ(wrong->found, "0 1e+19 nan");
}

TEST(PoseLimits, QuaternionsAreOfLengthOne) {
    EXPECT_FALSE(orientation_mismatch(glm::dquat(1, 0, 0, 0)));
    EXPECT_FALSE(orientation_mismatch(glm::dquat(0.5, -0.5, 0.5, -0.5)));
    for (const glm::dquat& q : {glm::dquat(0, 0, 0, 0), glm::dquat(1.01, 0, 0, 0), glm::dquat(nan, 0, 0, 1),
                                glm::dquat(0, inf, 0, 0), glm::dquat(1e200, 1e200, 0, 0)})
        EXPECT_TRUE(orientation_mismatch(q)) << q.w << " " << q.x;
    EXPECT_EQ(orientation_mismatch(glm::dquat(2, 0, 0, 0))->found, "length 2");
}

TEST(PoseLimits, APoseIsBoth) {
    EXPECT_FALSE(pose_mismatch({}));
    EXPECT_EQ(pose_mismatch({{0, 0, 2e9}, glm::dquat(1, 0, 0, 0)})->found, "0 0 2e+09");
    EXPECT_EQ(pose_mismatch({{0, 0, 0}, glm::dquat(0, 0, 0, 0)})->found, "length 0");
}

TEST(PoseLimits, ARangeHoldsItsEndsAndNoNaN) {
    EXPECT_FALSE(range_mismatch(0, 0, max_ipd_m));
    EXPECT_FALSE(range_mismatch(max_ipd_m, 0, max_ipd_m));
    for (const double bad : {-0.001, 10.001, 1e19, inf, nan})
        EXPECT_TRUE(range_mismatch(bad, 0, max_ipd_m)) << bad;
    EXPECT_EQ(range_mismatch(nan, 0, 10)->expected, "a number from 0 to 10");
    EXPECT_EQ(range_mismatch(nan, 0, 10)->found, "nan");
}

}  // namespace
}  // namespace equistream
