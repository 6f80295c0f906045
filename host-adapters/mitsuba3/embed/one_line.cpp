#include "one_line.h"

namespace equistream::mitsuba_host {
namespace {

constexpr const char* zero_width_space = "\xe2\x80\x8b";

std::string without(std::string text, const std::string& part) {
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at))
        text.erase(at, part.size());
    return text;
}

}  // namespace

std::string one_line(const std::string& message) {
    std::string line;
    for (const char c : without(message, zero_width_space)) {
        const bool blank = static_cast<unsigned char>(c) <= 0x20;
        if (!blank)
            line += c;
        else if (!line.empty() && line.back() != ' ')
            line += ' ';
    }
    while (!line.empty() && line.back() == ' ')
        line.pop_back();
    return line;
}

}  // namespace equistream::mitsuba_host
