#pragma once
/// How the plugins refuse: one line, without the place in the source that Mitsuba's own Throw puts before it.
#include <tinyformat.h>

#include <stdexcept>

namespace equistream::mitsuba_host {

template <typename... Values>
[[noreturn]] void refuse(const char* format, const Values&... values) {
    throw std::runtime_error(tfm::format(format, values...));
}

}  // namespace equistream::mitsuba_host
