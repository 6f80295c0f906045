#include "objects.h"

#include <equistream/error.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

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

void require_within(GLenum limit, std::int64_t wanted, const std::string& what) {
    GLint64 most = 0;
    glGetInteger64v(limit, &most);
    if (wanted > most)
        throw WorkError(expected_found("OpenGL", what + " up to " + std::to_string(most) + " (this driver's limit)",
                                       std::to_string(wanted)));
}

/// Takes all that are pending. Whether one says that there is no memory.
bool take_errors() {
    constexpr int max_flags = 8;
    bool no_memory = false;
    for (int i = 0; i < max_flags; ++i) {
        const GLenum error = glGetError();
        if (error == GL_NO_ERROR)
            break;
        no_memory = no_memory || error == GL_OUT_OF_MEMORY;
    }
    return no_memory;
}

/// `ask` asks for its storage. Errors from before that are somebody else's.
template <typename Ask>
void require_memory(const std::string& what, const Ask& ask) {
    take_errors();
    ask();
    if (take_errors())
        throw WorkError("OpenGL: the driver has no memory for " + what);
}

void require_size(Size size, int layers) {
    require_within(GL_MAX_TEXTURE_SIZE, std::max(size.width, size.height), "sides of textures");
    require_within(GL_MAX_ARRAY_TEXTURE_LAYERS, layers, "layers of a texture");
}

std::string in_words(Size size, int layers) {
    const std::string each = std::to_string(size.width) + "x" + std::to_string(size.height);
    return layers == 1 ? "a texture of " + each : std::to_string(layers) + " layers of " + each;
}

Buffer make_buffer(const void* content, std::size_t bytes, GLbitfield flags) {
    require_within(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, std::int64_t(bytes), "bytes of a shader's storage block");
    GLuint name = 0;
    glCreateBuffers(1, &name);
    Buffer buffer(name);
    // A buffer of nothing is an error of use; one byte is not.
    require_memory("a buffer of " + std::to_string(bytes) + " bytes", [&] {
        glNamedBufferStorage(name, bytes == 0 ? 1 : GLsizeiptr(bytes), bytes == 0 ? nullptr : content, flags);
    });
    return buffer;
}

}  // namespace

std::int64_t max_storage_bytes() {
    GLint64 bytes = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
    return bytes;
}

Texture make_texture(Size size, GLenum format) {
    require_size(size, 1);
    Texture texture = make(GL_TEXTURE_2D);
    require_memory(in_words(size, 1), [&] { glTextureStorage2D(texture.name(), 1, format, size.width, size.height); });
    return texture;
}

Texture make_layered_texture(Size size, int layers, GLenum format, int levels) {
    require_size(size, layers);
    Texture texture = make(GL_TEXTURE_2D_ARRAY);
    require_memory(in_words(size, layers),
                   [&] { glTextureStorage3D(texture.name(), levels, format, size.width, size.height, layers); });
    return texture;
}

Buffer make_buffer(std::span<const std::byte> content, GLbitfield flags) {
    return make_buffer(content.data(), content.size(), flags);
}

Buffer make_buffer(std::size_t bytes, GLbitfield flags) {
    return make_buffer(nullptr, bytes, flags);
}

void require_complete(const Framebuffer& framebuffer) {
    const GLenum status = glCheckNamedFramebufferStatus(framebuffer.name(), GL_FRAMEBUFFER);
    if (status != GL_FRAMEBUFFER_COMPLETE)
        throw WorkError("OpenGL: the driver cannot draw into the framebuffer (status " + std::to_string(status) + ")");
}

Framebuffer make_framebuffer(std::span<const GLuint> colours, GLuint depth) {
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    Framebuffer framebuffer(name);
    std::vector<GLenum> drawn;
    for (const GLuint colour : colours) {
        drawn.push_back(GL_COLOR_ATTACHMENT0 + GLenum(drawn.size()));
        glNamedFramebufferTexture(name, drawn.back(), colour, 0);
    }
    if (depth != 0)
        glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth, 0);
    glNamedFramebufferDrawBuffers(name, GLsizei(drawn.size()), drawn.data());
    require_complete(framebuffer);
    return framebuffer;
}

VertexArray make_vertex_array() {
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    return VertexArray(name);
}

void finish_pictures() {
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                    GL_FRAMEBUFFER_BARRIER_BIT);
}

void download(GLuint texture, int layer, Size size, const PixelLayout& layout, void* to, std::size_t row_bytes) {
    // A call's size has 32 bits.
    constexpr std::size_t max_bytes = std::numeric_limits<GLsizei>::max();
    const int band = int(std::clamp<std::size_t>(max_bytes / row_bytes, 1, std::size_t(size.height)));
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glPixelStorei(GL_PACK_ROW_LENGTH, GLint(row_bytes / layout.bytes));
    for (int row = 0; row < size.height; row += band) {
        const int rows = std::min(band, size.height - row);
        glGetTextureSubImage(texture, 0, 0, row, layer, size.width, rows, 1, layout.format, layout.type,
                             GLsizei(row_bytes * std::size_t(rows)),
                             static_cast<std::byte*>(to) + std::size_t(row) * row_bytes);
    }
    glPixelStorei(GL_PACK_ROW_LENGTH, 0);
}

}  // namespace equistream::gl
