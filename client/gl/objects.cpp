#include "objects.h"

namespace equistream::gl {

namespace {

Texture make(GLenum target) {
    GLuint name = 0;
    glCreateTextures(target, 1, &name);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        glTextureParameteri(name, filter, GL_NEAREST);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
        glTextureParameteri(name, wrap, GL_CLAMP_TO_EDGE);
    return Texture(name);
}

}  // namespace

Texture make_texture(Size size, GLenum format) {
    Texture texture = make(GL_TEXTURE_2D);
    glTextureStorage2D(texture.name(), 1, format, size.width, size.height);
    return texture;
}

Texture make_layered_texture(Size size, int layers, GLenum format) {
    Texture texture = make(GL_TEXTURE_2D_ARRAY);
    glTextureStorage3D(texture.name(), 1, format, size.width, size.height, layers);
    return texture;
}

Buffer make_buffer(std::span<const std::byte> content, GLbitfield flags) {
    GLuint name = 0;
    glCreateBuffers(1, &name);
    // A buffer of nothing is an error of use; one byte is not.
    glNamedBufferStorage(name, content.empty() ? 1 : GLsizeiptr(content.size()),
                         content.empty() ? nullptr : content.data(), flags);
    return Buffer(name);
}

Buffer make_buffer(std::size_t bytes, GLbitfield flags) {
    GLuint name = 0;
    glCreateBuffers(1, &name);
    glNamedBufferStorage(name, bytes == 0 ? 1 : GLsizeiptr(bytes), nullptr, flags);
    return Buffer(name);
}

}  // namespace equistream::gl
