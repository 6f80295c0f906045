#pragma once
/// Text for a person, in lines that fit. All in a header: the dispatcher links nothing of CLI11.
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <string_view>

namespace equistream::cli {

/// Of COLUMNS, else of the terminal that is written to, else 100.
inline std::size_t output_columns() {
    constexpr std::size_t least = 40, otherwise = 100;
    const char* told = std::getenv("COLUMNS");
    std::size_t columns = told != nullptr ? std::strtoul(told, nullptr, 10) : 0;
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {  // a pager's terminal is the second one's
        winsize size{};
        if (columns == 0 && ioctl(stream, TIOCGWINSZ, &size) == 0)
            columns = size.ws_col;
    }
    return columns == 0 ? otherwise : std::max(columns, least);
}

/// One line of text in lines that begin below each other, after `head`. A line of two columns goes on below its second.
inline std::string wrapped_line(const std::string& head, std::string_view text, std::size_t columns) {
    const bool has_columns = text.find(' ') == text.find("  ");
    const std::size_t gap = has_columns ? std::min(text.find("  "), text.size()) : text.size();
    const std::size_t second = text.find_first_not_of(' ', gap);
    const std::string indent(head.size() + (second == text.npos ? 0 : second), ' ');
    std::string lines, line = head;
    std::size_t at = 0;
    while (line.size() + text.size() - at > columns) {
        const std::size_t room = columns - std::min(columns, line.size());
        std::size_t end = text.rfind(' ', at + room);
        if (end == text.npos || end <= at)
            end = text.find(' ', at + 1);  // a word that is longer than the line
        if (end == text.npos)
            break;
        const std::string_view part = text.substr(at, end - at);
        lines.append(line).append(part.substr(0, part.find_last_not_of(' ') + 1)).append("\n");
        line = indent;
        at = std::min(text.find_first_not_of(' ', end), text.size());
    }
    line += text.substr(at);
    return lines + line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
}

/// The same of text whose own lines stay apart.
inline std::string wrapped(const std::string& head, std::string_view text, std::size_t columns) {
    std::string lines, first = head;
    for (;;) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        lines += wrapped_line(first, text.substr(0, end), columns);
        if (end == text.size())
            return lines;
        text.remove_prefix(end + 1);
        first.assign(head.size(), ' ');
    }
}

}  // namespace equistream::cli
