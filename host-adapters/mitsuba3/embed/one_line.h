#pragma once
/// Mitsuba's messages, some of which are paragraphs, as one line.
#include <string>

namespace equistream::mitsuba_host {

/// Lines joined with single spaces, zero-width characters taken out.
std::string one_line(const std::string& message);

}  // namespace equistream::mitsuba_host
