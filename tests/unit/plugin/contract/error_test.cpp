// What users read is one line, whatever a file put into it.
#include <equistream/error.h>

#include <gtest/gtest.h>

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
}  // namespace equistream
