#pragma once
/// State of the host's context that comes back when this goes: what client.h promises of es_client_draw. Meanwhile
/// pixel transfers are of the client's own memory, row after row, and no plane of the host's clips what is drawn.
#include <epoxy/gl.h>

#include <array>

namespace equistream::gl {

class HostGlState {
public:
    HostGlState();
    ~HostGlState();
    HostGlState(const HostGlState&) = delete;
    HostGlState& operator=(const HostGlState&) = delete;

private:
    struct BufferTarget {
        GLenum target, binding;
    };
    struct PixelStore {
        GLenum name;
        GLint initial;  ///< in a new context
    };

    // As many as OpenGL 4.5 has at least.
    static constexpr GLuint viewport_count = 16, draw_buffer_count = 8, clip_plane_count = 8;

    static constexpr std::array<GLenum, 9> switches_ = {
        GL_COLOR_LOGIC_OP,      GL_CULL_FACE,         GL_DEPTH_CLAMP,        GL_DEPTH_TEST,  GL_FRAMEBUFFER_SRGB,
        GL_POLYGON_OFFSET_FILL, GL_PRIMITIVE_RESTART, GL_RASTERIZER_DISCARD, GL_STENCIL_TEST};
    static constexpr std::array<GLenum, 9> numbers_ = {GL_DRAW_FRAMEBUFFER_BINDING,
                                                       GL_READ_FRAMEBUFFER_BINDING,
                                                       GL_CURRENT_PROGRAM,
                                                       GL_VERTEX_ARRAY_BINDING,
                                                       GL_CLIP_ORIGIN,
                                                       GL_CLIP_DEPTH_MODE,
                                                       GL_CULL_FACE_MODE,
                                                       GL_DEPTH_FUNC,
                                                       GL_FRONT_FACE};
    static constexpr std::array<BufferTarget, 7> buffers_ = {
        {{GL_DISPATCH_INDIRECT_BUFFER, GL_DISPATCH_INDIRECT_BUFFER_BINDING},
         {GL_DRAW_INDIRECT_BUFFER, GL_DRAW_INDIRECT_BUFFER_BINDING},
         {GL_PARAMETER_BUFFER_ARB, GL_PARAMETER_BUFFER_BINDING_ARB},
         {GL_PIXEL_PACK_BUFFER, GL_PIXEL_PACK_BUFFER_BINDING},
         {GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_UNPACK_BUFFER_BINDING},
         {GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING},
         {GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING}}};
    static constexpr std::array<PixelStore, 16> pixel_stores_ = {{{GL_PACK_ALIGNMENT, 4},
                                                                  {GL_PACK_IMAGE_HEIGHT, 0},
                                                                  {GL_PACK_LSB_FIRST, 0},
                                                                  {GL_PACK_ROW_LENGTH, 0},
                                                                  {GL_PACK_SKIP_IMAGES, 0},
                                                                  {GL_PACK_SKIP_PIXELS, 0},
                                                                  {GL_PACK_SKIP_ROWS, 0},
                                                                  {GL_PACK_SWAP_BYTES, 0},
                                                                  {GL_UNPACK_ALIGNMENT, 4},
                                                                  {GL_UNPACK_IMAGE_HEIGHT, 0},
                                                                  {GL_UNPACK_LSB_FIRST, 0},
                                                                  {GL_UNPACK_ROW_LENGTH, 0},
                                                                  {GL_UNPACK_SKIP_IMAGES, 0},
                                                                  {GL_UNPACK_SKIP_PIXELS, 0},
                                                                  {GL_UNPACK_SKIP_ROWS, 0},
                                                                  {GL_UNPACK_SWAP_BYTES, 0}}};

    /// One of numbers_, as it was.
    GLuint number(GLenum name) const;

    std::array<GLboolean, switches_.size()> on_{};
    std::array<GLboolean, clip_plane_count> clips_{};
    std::array<GLboolean, draw_buffer_count> blends_{};
    std::array<GLboolean, viewport_count> scissors_{};
    std::array<GLint, numbers_.size()> values_{};
    std::array<GLint, buffers_.size()> bound_{};
    std::array<GLint, pixel_stores_.size()> stored_{};
    std::array<GLint, 2> polygon_mode_{};
    std::array<GLfloat, 4 * viewport_count> viewports_{};
    std::array<GLdouble, 2 * viewport_count> depth_ranges_{};
    std::array<GLboolean, 4 * draw_buffer_count> colour_masks_{};
    GLboolean depth_mask_ = GL_TRUE;
};

}  // namespace equistream::gl
