#pragma once
/// Numbers that GLSL has from the C++ headers. Each stage gives its own (gl/constants.cpp); CMake joins them.
#include <string>

namespace equistream::gl {

/// "#define NAME VALUE" lines that stand before the text of every stage.
const std::string& constants();

}  // namespace equistream::gl
