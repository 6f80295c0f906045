#pragma once
/// What drawing needs beyond OpenGL 4.5.
#include <string>

namespace equistream::gl {

/// What the current context lacks of it; empty where it has all.
std::string missing_requirement();

}  // namespace equistream::gl
