#pragma once
/// OpenGL objects that free themselves; the context they were made in must be current when they do. Movable.
#include <epoxy/gl.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace equistream::gl {

/// `Kind` has free(name).
template <typename Kind>
class Object {
public:
    Object() = default;
    explicit Object(GLuint name) : name_(name) {}
    Object(Object&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    Object& operator=(Object&& other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    ~Object() {
        if (name_ != 0)
            Kind::free(name_);
    }
    GLuint name() const { return name_; }
    explicit operator bool() const { return name_ != 0; }

private:
    GLuint name_ = 0;
};

struct TextureKind {
    static void free(GLuint name) { glDeleteTextures(1, &name); }
};
struct BufferKind {
    static void free(GLuint name) { glDeleteBuffers(1, &name); }
};
struct FramebufferKind {
    static void free(GLuint name) { glDeleteFramebuffers(1, &name); }
};
struct VertexArrayKind {
    static void free(GLuint name) { glDeleteVertexArrays(1, &name); }
};
struct SamplerKind {
    static void free(GLuint name) { glDeleteSamplers(1, &name); }
};
struct QueryKind {
    static void free(GLuint name) { glDeleteQueries(1, &name); }
};

using Texture = Object<TextureKind>;
using Buffer = Object<BufferKind>;
using Framebuffer = Object<FramebufferKind>;
using VertexArray = Object<VertexArrayKind>;
using Sampler = Object<SamplerKind>;
using Query = Object<QueryKind>;

struct Size {
    int width = 0, height = 0;
    bool operator==(const Size&) const = default;
};

/// Immutable storage, one level, nearest samples, clamped to its edges. Storage of any kind throws WorkError in one
/// line where the driver's limits, of textures and of the storage blocks of shaders, or its memory are too small.
Texture make_texture(Size size, GLenum format);
/// The same with `layers` of them (GL_TEXTURE_2D_ARRAY), and so many levels.
Texture make_layered_texture(Size size, int layers, GLenum format, int levels = 1);
Buffer make_buffer(std::span<const std::byte> content, GLbitfield flags = 0);
Buffer make_buffer(std::size_t bytes, GLbitfield flags);

template <typename T>
Buffer make_buffer_of(std::span<const T> content, GLbitfield flags = 0) {
    return make_buffer(std::as_bytes(content), flags);
}

/// Of one storage block of a shader's, at most.
std::int64_t max_storage_bytes();

/// What comes after may sample, copy, draw over or write the textures that shaders wrote.
void finish_pictures();

/// Whose status is not complete throws WorkError.
void require_complete(const Framebuffer& framebuffer);
/// Draws to all layers of these textures, `depth` being 0 or a depth buffer. Throws as require_complete does.
Framebuffer make_framebuffer(std::span<const GLuint> colours, GLuint depth);

/// For passes whose vertices are numbers alone.
VertexArray make_vertex_array();

/// How pixels lie in memory.
struct PixelLayout {
    GLenum format, type;
    std::size_t bytes;  ///< of a pixel
};

/// Copies the first rows and columns of a layer (0 of a texture without layers) to memory whose rows are `row_bytes`
/// apart, a whole number of pixels. Waits for the GPU.
void download(GLuint texture, int layer, Size size, const PixelLayout& layout, void* to, std::size_t row_bytes);

}  // namespace equistream::gl
