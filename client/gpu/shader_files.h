#pragma once
/// The GLSL files that CMake compiles into the library, and numbers that GLSL has from the C++ headers: each stage
/// gives its own (gl/constants.cpp).
#include <span>
#include <string>
#include <string_view>

namespace equistream::gl {

struct ShaderFile {
    std::string_view name, text;
};
std::span<const ShaderFile> shader_files();

/// "#define NAME VALUE" lines that stand before the text of every stage.
const std::string& constants();

}  // namespace equistream::gl
