#include "memory.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace equistream::gl {

namespace {

/// Drivers give names in their order: after so many that are free there are no more.
constexpr GLuint max_free_names = 256;
/// Beyond it a texture has no more levels.
constexpr GLint max_levels = 16;

std::size_t bytes_of_texel(GLuint texture, GLint level) {
    constexpr std::array sizes = {GL_TEXTURE_RED_SIZE,   GL_TEXTURE_GREEN_SIZE, GL_TEXTURE_BLUE_SIZE,
                                  GL_TEXTURE_ALPHA_SIZE, GL_TEXTURE_DEPTH_SIZE, GL_TEXTURE_STENCIL_SIZE};
    GLint bits = 0;
    for (const GLint size : sizes) {
        GLint each = 0;
        glGetTextureLevelParameteriv(texture, level, GLenum(size), &each);
        bits += each;
    }
    return std::size_t(std::max(0, bits)) / 8;
}

std::size_t bytes_of_texture(GLuint texture) {
    GLint target = 0;
    glGetTextureParameteriv(texture, GL_TEXTURE_TARGET, &target);
    if (target == GL_TEXTURE_BUFFER || target == GL_NONE)
        return 0;  // a buffer's own bytes
    std::size_t bytes = 0;
    for (GLint level = 0; level < max_levels; ++level) {
        GLint width = 0, height = 0, depth = 0;
        glGetTextureLevelParameteriv(texture, level, GL_TEXTURE_WIDTH, &width);
        glGetTextureLevelParameteriv(texture, level, GL_TEXTURE_HEIGHT, &height);
        glGetTextureLevelParameteriv(texture, level, GL_TEXTURE_DEPTH, &depth);
        if (width <= 0)
            break;
        bytes += std::size_t(width) * std::size_t(std::max(1, height)) * std::size_t(std::max(1, depth)) *
                 bytes_of_texel(texture, level);
    }
    return bytes;
}

std::size_t bytes_of_buffer(GLuint buffer) {
    GLint64 bytes = 0;
    glGetNamedBufferParameteri64v(buffer, GL_BUFFER_SIZE, &bytes);
    return std::size_t(std::max<GLint64>(0, bytes));
}

template <typename Is, typename Bytes>
std::size_t sum(const Is& is, const Bytes& bytes_of) {
    std::size_t bytes = 0;
    GLuint free_names = 0;
    for (GLuint name = 1; free_names < max_free_names; ++name) {
        const bool is_used = is(name) == GL_TRUE;
        free_names = is_used ? 0 : free_names + 1;
        bytes += is_used ? bytes_of(name) : 0;
    }
    return bytes;
}

}  // namespace

std::size_t object_bytes() {
    return sum([](GLuint name) { return glIsTexture(name); }, bytes_of_texture) +
           sum([](GLuint name) { return glIsBuffer(name); }, bytes_of_buffer);
}

}  // namespace equistream::gl
