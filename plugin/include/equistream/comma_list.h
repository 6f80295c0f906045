#pragma once
/// Lists as people type and read them: words between commas.
#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

/// `text` without the spaces, tabs and carriage returns at its ends.
inline std::string_view trimmed(std::string_view text) {
    constexpr std::string_view space = " \t\r";
    const std::size_t first = text.find_first_not_of(space);
    return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(space) - first + 1);
}

/// The words of a list, trimmed, empty ones included: always one more than there are commas. They refer to `list`.
inline std::vector<std::string_view> split_at_commas(std::string_view list) {
    std::vector<std::string_view> words;
    for (std::size_t begin = 0; begin <= list.size();) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        words.push_back(trimmed(list.substr(begin, end - begin)));
        begin = end + 1;
    }
    return words;
}

/// "a, b or c" of a, b and c; `last` stands before the last one: " or ".
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
