#include "settings_text.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <sstream>
#include <string_view>

namespace equistream::cli {

namespace {

constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";

bool is_quote(char c) {
    return c == '"' || c == '\'';
}

/// Where a remark begins, or the end. Nothing where a quote does not end.
std::size_t end_of_value(const std::string& text, bool& is_whole) {
    char quote = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool begins =
            i == 0 || text[i - 1] == ' ' || text[i - 1] == '\t' || text[i - 1] == '[' || text[i - 1] == ',';
        if (quote != 0)
            quote = text[i] == quote ? 0 : quote;
        else if (is_quote(text[i]) && begins)  // else an apostrophe
            quote = text[i];
        else if ((text[i] == '#' || text[i] == ';') && begins)
            return i;
    }
    is_whole = quote == 0;
    return text.size();
}

std::string quoted_if_needed(const std::string& value) {
    if (value.empty() || is_quote(value.front()) || value.front() == '[' || value.find_first_of(" \t,#") == value.npos)
        return value;
    const char quote = value.find('"') == value.npos ? '"' : '\'';
    return quote + value + quote;
}

}  // namespace

std::string settings_for_reader(const std::string& text, const std::string& file) {
    std::istringstream lines(text.starts_with(byte_order_mark) ? text.substr(byte_order_mark.size()) : text);
    std::string line, result;
    for (int number = 1; std::getline(lines, line); ++number) {
        const std::string bare(trimmed(line));
        const std::size_t equals = line.find('=');
        if (bare.empty() || bare.front() == '[' || equals == line.npos || bare.front() == '#' || bare.front() == ';') {
            result += bare + '\n';
            continue;
        }
        const std::string value(trimmed(std::string_view(line).substr(equals + 1)));
        bool is_whole = true;
        const std::size_t end = end_of_value(value, is_whole);
        if (!is_whole)
            throw InputError(
                expected_found(file + ":" + std::to_string(number), "a quote at the value's end", "'" + value + "'"));
        result += line.substr(0, equals + 1) + ' ' +
                  quoted_if_needed(std::string(trimmed(std::string_view(value).substr(0, end)))) + '\n';
    }
    return result;
}

}  // namespace equistream::cli
