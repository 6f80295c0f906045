#include "program.h"

#include "shader_files.h"

#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <cctype>
#include <set>
#include <stdexcept>

namespace equistream::gl {

namespace {

struct ShaderKind {
    static void free(GLuint name) { glDeleteShader(name); }
};

std::string_view file_text(std::string_view file) {
    for (const ShaderFile& each : shader_files())
        if (each.name == file)
            return each.text;
    throw std::logic_error("no shader file " + std::string(file));
}

using Included = std::set<std::string, std::less<>>;

void append(std::string& text, std::string_view from, Included& included) {
    constexpr std::string_view include = "#include \"";
    while (!from.empty()) {
        const std::size_t end = std::min(from.find('\n'), from.size() - 1) + 1;
        const std::string_view line = from.substr(0, end);
        from.remove_prefix(end);
        if (!line.starts_with(include))
            text += line;
        else if (const std::string_view name =
                     line.substr(include.size(), line.find('"', include.size()) - include.size());
                 included.emplace(name).second)
            append(text, file_text(name), included);
    }
}

std::string with_includes(std::string_view from) {
    std::string text;
    Included included;
    append(text, from, included);
    return text;
}

template <typename GetStatus, typename GetLog>
void require(GetStatus get_status, GetLog get_log, GLuint name, GLenum what, std::string_view where) {
    GLint done = GL_FALSE;
    get_status(name, what, &done);
    if (done == GL_TRUE)
        return;
    std::string log(4096, '\0');
    GLsizei length = 0;
    get_log(name, GLsizei(log.size()), &length, log.data());
    log.resize(std::size_t(std::max(length, 0)));
    throw std::logic_error(std::string(where) + ": " + log);
}

/// Extensions have to be named before all else.
std::string take_extensions(std::string& text) {
    std::string taken;
    for (std::size_t at = text.find("#extension"); at != std::string::npos; at = text.find("#extension", at)) {
        const std::size_t length = text.find('\n', at) + 1 - at;
        taken += text.substr(at, length);
        text.erase(at, length);
    }
    return taken;
}

std::string whole_text(const Stage& stage, std::span<const std::string> defines) {
    std::string body = stage.text.empty() ? shader_text(stage.file) : with_includes(stage.text);
    std::string text = "#version 450 core\n" + take_extensions(body) + "#define GROUP_WIDTH " +
                       std::to_string(group_width) + "\n#define GROUP_HEIGHT " + std::to_string(group_height) + "\n" +
                       constants() + with_includes(file_text("shaders.glsl"));
    for (const std::string& define : defines)
        text += "#define " + define + "\n";
    return text + body;
}

Object<ShaderKind> compiled(const Stage& stage, const std::string& text) {
    Object<ShaderKind> shader(glCreateShader(stage.type));
    const char* source = text.c_str();
    glShaderSource(shader.name(), 1, &source, nullptr);
    glCompileShader(shader.name());
    require(glGetShaderiv, glGetShaderInfoLog, shader.name(), GL_COMPILE_STATUS, stage.file);
    return shader;
}

/// Whether `word` stands in `text` by itself.
bool has_word(std::string_view text, std::string_view word) {
    const auto is_part = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
    for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + 1)) {
        const std::size_t end = at + word.size();
        if ((at == 0 || !is_part(text[at - 1])) && (end == text.size() || !is_part(text[end])))
            return true;
    }
    return false;
}

}  // namespace

std::string shader_text(std::string_view file) {
    return with_includes(file_text(file));
}

Program::Program(std::initializer_list<Stage> stages, std::span<const std::string> defines)
    : program_(glCreateProgram()) {
    std::vector<Object<ShaderKind>> shaders;
    for (const Stage& stage : stages) {
        const std::string text = whole_text(stage, defines);
        shaders.push_back(compiled(stage, text));
        text_ += text;
        glAttachShader(name(), shaders.back().name());
    }
    glLinkProgram(name());
    require(glGetProgramiv, glGetProgramInfoLog, name(), GL_LINK_STATUS, stages.begin()->file);
}

GLint Program::location(const char* uniform) const {
    for (const auto& [known, at] : locations_)
        if (known == uniform)
            return at;
    const GLint at = glGetUniformLocation(name(), uniform);
    if (at < 0 && !has_word(text_, uniform))
        throw std::logic_error(std::string("a shader has no uniform ") + uniform);
    locations_.emplace_back(uniform, at);
    return at;
}

void Program::set(const char* uniform, int value) const {
    glProgramUniform1i(name(), location(uniform), value);
}
void Program::set(const char* uniform, float value) const {
    glProgramUniform1f(name(), location(uniform), value);
}
void Program::set(const char* uniform, glm::vec2 value) const {
    glProgramUniform2f(name(), location(uniform), value.x, value.y);
}
void Program::set(const char* uniform, glm::vec3 value) const {
    glProgramUniform3f(name(), location(uniform), value.x, value.y, value.z);
}
void Program::set(const char* uniform, glm::ivec2 value) const {
    glProgramUniform2i(name(), location(uniform), value.x, value.y);
}
void Program::set(const char* uniform, glm::ivec3 value) const {
    glProgramUniform3i(name(), location(uniform), value.x, value.y, value.z);
}
void Program::set(const char* uniform, const glm::mat3& value) const {
    glProgramUniformMatrix3fv(name(), location(uniform), 1, GL_FALSE, glm::value_ptr(value));
}
void Program::set(const char* uniform, const glm::mat4& value) const {
    glProgramUniformMatrix4fv(name(), location(uniform), 1, GL_FALSE, glm::value_ptr(value));
}

void Program::dispatch(Size size, int layers) const {
    use();
    glDispatchCompute(GLuint((size.width + group_width - 1) / group_width),
                      GLuint((size.height + group_height - 1) / group_height), GLuint(layers));
}

void Program::dispatch_indirect(GLuint buffer, std::size_t offset) const {
    use();
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, buffer);
    glDispatchComputeIndirect(GLintptr(offset));
}

}  // namespace equistream::gl
