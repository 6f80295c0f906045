#include <equistream/text.h>

#include <gtest/gtest.h>

namespace equistream {
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
}  // namespace equistream
