#pragma once
/// Text with numbers in it.
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace equistream {

/// printf into a string, however long.
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

/// As short as reads back the same.
inline std::string in_words(double value) {
    const std::string shorter = formatted("%g", value);
    return std::strtod(shorter.c_str(), nullptr) == value || std::isnan(value) ? shorter : formatted("%.17g", value);
}

/// "960x480"
inline std::string size_text(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace equistream
