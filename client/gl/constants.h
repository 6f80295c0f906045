#pragma once
/// Numbers that GLSL has from the C++ headers, so that neither can differ from the other.
#include <string>

namespace equistream::gl {

/// "#define NAME VALUE" lines that stand before the text of every stage.
const std::string& constants();

}  // namespace equistream::gl
