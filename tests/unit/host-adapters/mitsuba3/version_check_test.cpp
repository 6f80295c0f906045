#include <host-adapters/mitsuba3/plugins/version_check.h>

#include <gtest/gtest.h>

namespace equistream::mitsuba_host {
namespace {

const std::string right = "Mitsuba version 3.9.1 (master[b27bf41d], Linux, 64bit, 2 threads, 8-wide SIMD)";

std::string refusal(const std::string& build) {
    try {
        require_release("equirect", build, "3.9.1");
    } catch (const std::runtime_error& error) {
        return error.what();
    }
    return "";
}

TEST(VersionCheck, the_release_is_read) {
    EXPECT_EQ(release_in(right), "3.9.1");
    EXPECT_EQ(release_in("Mitsuba version 3.10.0"), "3.10.0");
    EXPECT_EQ(release_in("something else"), "");
}

TEST(VersionCheck, the_right_one_is_accepted) {
    EXPECT_EQ(refusal(right), "");
}

TEST(VersionCheck, others_are_refused_in_one_line) {
    EXPECT_EQ(
        refusal("Mitsuba version 3.9.0 (master[0], Linux)"),
        "equistream's plugin \"equirect\": expected Mitsuba 3.9.1, for which it was compiled, found Mitsuba 3.9.0");
    EXPECT_NE(refusal("Mitsuba version 3.9.10 (x)").find("found Mitsuba 3.9.10"), std::string::npos);
    EXPECT_NE(refusal("").find("found \"\""), std::string::npos);
}

}  // namespace
}  // namespace equistream::mitsuba_host
