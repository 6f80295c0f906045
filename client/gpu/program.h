#pragma once
/// Programs from the GLSL files that are compiled into the library (gl/*.glsl of the stages).
#include "objects.h"

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::gl {

struct ProgramKind {
    static void free(GLuint name) { glDeleteProgram(name); }
};

struct Stage {
    GLenum type = GL_COMPUTE_SHADER;
    std::string_view file;    ///< its name among the compiled-in ones
    std::string_view text{};  ///< instead of a compiled-in file's, of which it may include some
};

/// One linked program. A name that its text does not have is a mistake of ours and throws std::logic_error: it shows in
/// the first test that draws. What the compiler found unused, one driver's more than another's, is set without effect.
class Program {
public:
    /// `defines` stand before each stage's text, after constants(): "NAME VALUE".
    explicit Program(std::initializer_list<Stage> stages, std::span<const std::string> defines = {});
    /// A compute shader alone.
    explicit Program(const char* file, std::span<const std::string> defines = {})
        : Program({{GL_COMPUTE_SHADER, file}}, defines) {}

    GLuint name() const { return program_.name(); }
    void use() const { glUseProgram(name()); }

    void set(const char* uniform, int value) const;
    void set(const char* uniform, float value) const;
    void set(const char* uniform, glm::vec2 value) const;
    void set(const char* uniform, glm::vec3 value) const;
    void set(const char* uniform, glm::ivec2 value) const;
    void set(const char* uniform, glm::ivec3 value) const;
    void set(const char* uniform, const glm::mat3& value) const;
    void set(const char* uniform, const glm::mat4& value) const;

    /// Whether the compiler found a use for such a uniform.
    bool reads(const char* uniform) const { return glGetUniformLocation(name(), uniform) >= 0; }

    /// A compute program over `size` in groups of 16x8.
    void dispatch(Size size, int layers = 1) const;
    /// As many groups as three words of a buffer say, in whatever groups the shader has.
    void dispatch_indirect(GLuint buffer, std::size_t offset) const;

private:
    GLint location(const char* uniform) const;

    Object<ProgramKind> program_;
    std::string text_;  ///< of all stages
    mutable std::vector<std::pair<std::string, GLint>> locations_;
};

/// A compiled-in file with its `#include "NAME"` lines replaced by what they name, each once. Throws std::logic_error.
std::string shader_text(std::string_view file);

/// Work groups that Program::dispatch counts on; shaders get it as GROUP_WIDTH and GROUP_HEIGHT.
inline constexpr int group_width = 16, group_height = 8;

}  // namespace equistream::gl
