#pragma once
/// OpenGL objects that free themselves; the context they were made in must be current when they do. Movable.
#include <epoxy/gl.h>

#include <cstddef>
#include <span>
#include <utility>

namespace equistream::gl {

/// `Kind` has make() and free(name).
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
struct QueryKind {
    static void free(GLuint name) { glDeleteQueries(1, &name); }
};

using Texture = Object<TextureKind>;
using Buffer = Object<BufferKind>;
using Framebuffer = Object<FramebufferKind>;
using VertexArray = Object<VertexArrayKind>;
using Query = Object<QueryKind>;

struct Size {
    int width = 0, height = 0;
    bool operator==(const Size&) const = default;
};

/// Immutable storage, one level, nearest samples, clamped to its edges.
Texture make_texture(Size size, GLenum format);
/// The same with `layers` of them (GL_TEXTURE_2D_ARRAY).
Texture make_layered_texture(Size size, int layers, GLenum format);
Buffer make_buffer(std::span<const std::byte> content, GLbitfield flags = 0);
Buffer make_buffer(std::size_t bytes, GLbitfield flags);

template <typename T>
Buffer make_buffer_of(std::span<const T> content, GLbitfield flags = 0) {
    return make_buffer(std::as_bytes(content), flags);
}

}  // namespace equistream::gl
