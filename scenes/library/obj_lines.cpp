#include "obj_lines.h"

#include "file_bytes.h"

#include <equistream/error.h>

#include <charconv>
#include <cmath>

namespace equistream {

namespace {

constexpr std::uintmax_t file_size_limit = 0xffffffff;
constexpr std::size_t line_size_limit = 1 << 20;
constexpr std::string_view blanks = " \t\v\f";

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos)
        return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

}  // namespace

std::string_view ObjLine::next_word(std::size_t& at) const {
    const std::string_view text = rest;
    const std::size_t first = std::min(text.find_first_not_of(blanks, at), text.size());
    const std::size_t end = std::min(text.find_first_of(blanks, first), text.size());
    at = end;
    return text.substr(first, end - first);
}

ObjLines::ObjLines(const std::filesystem::path& file, const std::string& what)
    : file_(file.string()), stream_(open_regular_file(file, what)) {
    std::error_code error;
    if (const std::uintmax_t size = std::filesystem::file_size(file, error); size > file_size_limit)
        throw InputError(expected_found(file_, "a " + what + " below 4 GiB", std::to_string(size) + " bytes"));
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
    char start[3] = {};
    stream_.read(start, 3);
    stream_.clear();
    if (std::string_view(start, 3) != byte_order_mark)
        stream_.seekg(0);
}

bool ObjLines::read_physical(std::string& line) {
    std::streambuf& bytes = *stream_.rdbuf();
    constexpr int end = std::char_traits<char>::eof();
    int c = bytes.sbumpc();
    if (c == end)
        return false;
    ++read_;
    for (; c != end && c != '\n' && c != '\r'; c = bytes.sbumpc()) {
        if (c == 0)
            throw InputError(expected_found(where(read_), "text", "a zero byte"));
        if (line.size() >= line_size_limit)
            throw InputError(expected_found(where(read_), "a line below 1 MiB", "a longer one"));
        line += static_cast<char>(c);
    }
    if (c == '\r' && bytes.sgetc() == '\n')
        bytes.sbumpc();
    return true;
}

std::optional<ObjLine> ObjLines::next() {
    for (;;) {
        std::string text;
        if (!read_physical(text))
            return std::nullopt;
        ObjLine line;
        line.number = read_;
        std::string_view statement = trimmed(text);
        if (statement.empty() || statement.front() == '#')
            continue;
        while (statement.ends_with('\\')) {
            text.resize(static_cast<std::size_t>(statement.data() - text.data()) + statement.size() - 1);
            text += ' ';
            const bool more = read_physical(text);
            statement = trimmed(text);
            if (!more)
                break;
        }
        const std::size_t end = std::min(statement.find_first_of(blanks), statement.size());
        line.keyword = statement.substr(0, end);
        line.rest = trimmed(statement.substr(end));
        if (!line.keyword.empty())
            return line;
    }
}

std::optional<double> obj_number(std::string_view word) {
    if (word.starts_with('+'))
        word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || word.empty() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

}  // namespace equistream
