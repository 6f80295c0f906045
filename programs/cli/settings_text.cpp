#include "settings_text.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <sstream>
#include <string_view>
#include <utility>

namespace equistream::cli {

namespace {

constexpr std::string_view blanks = " \t";

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

struct ListPart {
    std::string_view text;  ///< without a remark
    bool is_end = false;
    std::string_view behind;  ///< the end, without a remark
    bool is_open = false;     ///< a quote has no end
};

/// Of one line of a list. Quotes count where an item begins.
ListPart list_part(std::string_view line) {
    char quote = 0;
    bool begins = true;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        if (quote != 0)
            quote = c == quote ? '\0' : quote;
        else if (is_quote(c) && begins)
            quote = c;
        else if (c == ']')
            return {line.substr(0, i + 1), true, without_remark(trimmed(line.substr(i + 1)))};
        else if (c == '#' && (i == 0 || blanks.find(line[i - 1]) != blanks.npos))
            return {trimmed(line.substr(0, i)), false, {}};
        begins = c == ',' || c == '[' || (begins && blanks.find(c) != blanks.npos);
    }
    return {line, false, {}, quote != 0};
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

std::string without_byte_order_mark(const std::string& text) {
    constexpr std::string_view mark = "\xef\xbb\xbf";
    return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

std::string settings_for_reader(const std::string& text, const std::string& file) {
    std::istringstream lines(without_byte_order_mark(text));
    std::string line, result;
    const auto refuse = [&](int number, const std::string& expected, std::string_view found) {
        throw InputError(expected_found(file + ":" + std::to_string(number), expected, "'" + std::string(found) + "'"));
    };
    int list_begins = 0;  // line number; 0: in no list
    for (int number = 1; std::getline(lines, line); ++number) {
        const std::string_view bare = trimmed(line);
        const std::size_t equals = bare.find('=');
        const std::string_view value = equals == bare.npos ? "" : trimmed(bare.substr(equals + 1));
        if (list_begins > 0 || value.starts_with('[')) {
            const ListPart part = list_part(list_begins > 0 ? bare : value);
            if (part.is_open)
                refuse(number, "a quote at the value's end", bare);
            if (!part.behind.empty())
                refuse(number, "nothing behind a list's ]", part.behind);
            if (list_begins == 0) {
                list_begins = number;
                result += std::string(bare.substr(0, equals)) + "= ";
            }
            result += part.text;
            if (part.is_end)  // one line, and as many as it was
                result += std::string(std::size_t(number - std::exchange(list_begins, 0) + 1), '\n');
        } else if (bare.empty() || bare.front() == '#' || bare.front() == ';' || bare.front() == '[' ||
                   equals == bare.npos) {
            result += std::string(without_remark(bare)) + '\n';
        } else {
            std::string problem;
            result += std::string(bare.substr(0, equals)) + "= " + one_value(value, problem) + '\n';
            if (!problem.empty())
                refuse(number, problem, value);
        }
    }
    if (list_begins > 0)
        refuse(list_begins, "a list that ends with ]", "[");
    return result;
}

}  // namespace equistream::cli
