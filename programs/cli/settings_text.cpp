#include "settings_text.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <sstream>
#include <string_view>

namespace equistream::cli {

namespace {

constexpr std::string_view byte_order_mark = "\xef\xbb\xbf", blanks = " \t";

bool is_quote(char c) {
    return c == '"' || c == '\'';
}

/// Up to a # at the beginning or after a blank.
std::string_view without_remark(std::string_view text) {
    for (std::size_t i = 0; i < text.size(); ++i)
        if (text[i] == '#' && (i == 0 || blanks.find(text[i - 1]) != blanks.npos))
            return trimmed(text.substr(0, i));
    return text;
}

/// Of one line, without brackets: what CLI11 takes for one value. Empty `problem`: nothing is wrong.
std::string one_value(std::string_view value, std::string& problem) {
    if (!value.empty() && is_quote(value.front())) {
        const std::size_t end = value.find(value.front(), 1);
        if (end == value.npos)
            problem = "a quote at the value's end";
        else if (!without_remark(trimmed(value.substr(end + 1))).empty())
            problem = "one value in quotes";
        else
            return std::string(value.substr(0, end + 1));
        return {};
    }
    const std::string bare(without_remark(value));
    if (bare.find_first_of(" \t,#") == bare.npos)
        return bare;
    const char quote = bare.find('"') == bare.npos ? '"' : '\'';
    if (bare.find(quote) != bare.npos)
        problem = "a value with one kind of quotes within";
    return quote + bare + quote;
}

}  // namespace

std::string settings_for_reader(const std::string& text, const std::string& file) {
    std::istringstream lines(text.starts_with(byte_order_mark) ? text.substr(byte_order_mark.size()) : text);
    std::string line, result;
    bool in_list = false;  // of several lines, which CLI11 puts together
    for (int number = 1; std::getline(lines, line); ++number) {
        const std::string_view bare = trimmed(line);
        const std::size_t equals = bare.find('=');
        const std::string_view value = equals == bare.npos ? "" : trimmed(bare.substr(equals + 1));
        if (in_list || value.starts_with('[')) {
            result += std::string(bare) + '\n';
            in_list = bare.find(']') == bare.npos;
        } else if (bare.empty() || bare.front() == '#' || bare.front() == ';' || bare.front() == '[' ||
                   equals == bare.npos) {
            result += std::string(without_remark(bare)) + '\n';
        } else {
            std::string problem;
            result += std::string(bare.substr(0, equals)) + "= " + one_value(value, problem) + '\n';
            if (!problem.empty())
                throw InputError(
                    expected_found(file + ":" + std::to_string(number), problem, "'" + std::string(value) + "'"));
        }
    }
    return result;
}

}  // namespace equistream::cli
