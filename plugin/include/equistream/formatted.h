#pragma once
/// printf into a string, however long.
#include <cstdarg>
#include <cstdio>
#include <string>

namespace equistream {

[[gnu::format(printf, 1, 2)]] inline std::string formatted(const char* format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, again)), '\0');
    va_end(again);
    std::vsnprintf(text.data(), text.size() + 1, format, arguments);
    va_end(arguments);
    return text;
}

}  // namespace equistream
