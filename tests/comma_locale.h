#pragma once
/// A host that asked for its user's locale, where a comma is the decimal sign: printf writes 0,5 and strtod stops at
/// the point of 0.5, while this lives. The C++ locale follows, so that streams group thousands too.
#include <gtest/gtest.h>

#include <clocale>
#include <cstdlib>
#include <locale>

namespace equistream::testing {

class CommaLocale {
public:
    CommaLocale() {
        setenv("LOCPATH", EQUISTREAM_LOCALES, 1);
        try {
            before_ = std::locale::global(std::locale("comma"));
        } catch (const std::runtime_error& error) {
            ADD_FAILURE() << EQUISTREAM_LOCALES << ": " << error.what();
        }
        EXPECT_STREQ(std::localeconv()->decimal_point, ",") << "else the test shows nothing";
    }
    ~CommaLocale() {
        std::locale::global(before_);
        unsetenv("LOCPATH");
    }
    CommaLocale(const CommaLocale&) = delete;
    CommaLocale& operator=(const CommaLocale&) = delete;

private:
    std::locale before_;
};

}  // namespace equistream::testing
