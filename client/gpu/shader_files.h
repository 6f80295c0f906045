#pragma once
/// The GLSL files that CMake compiles into the library.
#include <span>
#include <string_view>

namespace equistream::gl {

struct ShaderFile {
    std::string_view name, text;
};
std::span<const ShaderFile> shader_files();

}  // namespace equistream::gl
