#pragma once
/// Drawing state of the host's context that comes back when this goes: what client.h promises of es_client_draw.
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
    static constexpr std::array<GLenum, 12> switches_ = {
        GL_BLEND,        GL_CULL_FACE,        GL_DEPTH_CLAMP,       GL_DEPTH_TEST,
        GL_DITHER,       GL_FRAMEBUFFER_SRGB, GL_COLOR_LOGIC_OP,    GL_POLYGON_OFFSET_FILL,
        GL_SCISSOR_TEST, GL_STENCIL_TEST,     GL_PRIMITIVE_RESTART, GL_RASTERIZER_DISCARD};
    std::array<GLboolean, switches_.size()> on_{};
    GLint draw_framebuffer_ = 0, read_framebuffer_ = 0, program_ = 0, vertex_array_ = 0, active_texture_ = 0;
    GLint clip_origin_ = 0, clip_depth_ = 0, depth_function_ = 0, front_face_ = 0, pack_alignment_ = 0,
          unpack_alignment_ = 0, pixel_pack_ = 0, pixel_unpack_ = 0;
    std::array<GLint, 2> polygon_mode_{};
    std::array<GLint, 4> viewport_{}, scissor_{};
    std::array<GLboolean, 4> colour_mask_{};
    std::array<GLdouble, 2> depth_range_{};
    GLboolean depth_mask_ = GL_TRUE;
};

}  // namespace equistream::gl
