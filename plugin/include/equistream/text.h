#pragma once
/// Text with numbers in it. Numbers are written and read as in the "C" locale, with a decimal point, whatever locale
/// the host or a Python script has set: files, shaders and messages read the same everywhere.
#include <algorithm>
#include <charconv>
#include <clocale>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace equistream {

/// While it lives, C functions of this thread format and parse numbers as in the "C" locale. Other threads keep their
/// locale. For libraries that parse the text of an option; this project's own code uses formatted() and
/// parsed_number().
class PlainNumbers {
public:
    PlainNumbers() : before_(uselocale(plain())) {}
    ~PlainNumbers() { uselocale(before_); }
    PlainNumbers(const PlainNumbers&) = delete;
    PlainNumbers& operator=(const PlainNumbers&) = delete;

private:
    static locale_t plain() {
        static const locale_t locale = newlocale(LC_ALL_MASK, "C", locale_t{});
        return locale;
    }
    locale_t before_;
};

/// printf into a string of any length, in the "C" locale.
[[gnu::format(printf, 1, 2)]] inline std::string formatted(const char* format, ...) {
    const PlainNumbers plain;
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, again)), '\0');
    va_end(again);
    std::vsnprintf(text.data(), text.size() + 1, format, arguments);
    va_end(arguments);
    return text;
}

/// The whole text as a number: "-0.5", "1e9", "inf", "nan". nullopt if it has any other character, spaces too.
inline std::optional<double> parsed_number(std::string_view text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

/// `value` as text that reads back the same: %g if that suffices, else %.17g.
inline std::string in_words(double value) {
    const std::string shorter = formatted("%g", value);
    return parsed_number(shorter) == value || std::isnan(value) ? shorter : formatted("%.17g", value);
}

/// "960x480"
inline std::string size_text(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

// Lists of words between commas.

/// `text` without the spaces, tabs and carriage returns at its ends.
inline std::string_view trimmed(std::string_view text) {
    constexpr std::string_view space = " \t\r";
    const std::size_t first = text.find_first_not_of(space);
    return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(space) - first + 1);
}

/// The words of a list, trimmed, empty words included: one more than the list has commas. They are views into `list`.
inline std::vector<std::string_view> split_at_commas(std::string_view list) {
    std::vector<std::string_view> words;
    for (std::size_t begin = 0; begin <= list.size();) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        words.push_back(trimmed(list.substr(begin, end - begin)));
        begin = end + 1;
    }
    return words;
}

/// Joins words for a sentence: "a, b or c" for a, b, c. `last` is the text before the last word, such as " or ".
template <typename Words>
std::string in_a_sentence(const Words& words, std::string_view last) {
    std::string text;
    for (std::size_t i = 0; i < std::size(words); ++i) {
        if (i > 0)
            text += i + 1 == std::size(words) ? last : ", ";
        text += words[i];
    }
    return text;
}

}  // namespace equistream
