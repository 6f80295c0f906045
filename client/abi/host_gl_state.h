#pragma once
/// Drawing state of the host's context that comes back when this goes: what client.h promises of es_client_draw.
#include <epoxy/gl.h>

#include <algorithm>
#include <array>

namespace equistream::gl {

class HostGlState {
public:
    HostGlState() {
        for (std::size_t i = 0; i < switches_.size(); ++i)
            on_[i] = glIsEnabled(switches_[i]);
        for (std::size_t i = 0; i < numbers_.size(); ++i)
            glGetIntegerv(numbers_[i], &values_[i]);
        glGetIntegerv(GL_POLYGON_MODE, polygon_mode_.data());
        glGetIntegerv(GL_VIEWPORT, viewport_.data());
        glGetIntegerv(GL_SCISSOR_BOX, scissor_.data());
        glGetBooleanv(GL_COLOR_WRITEMASK, colour_mask_.data());
        glGetDoublev(GL_DEPTH_RANGE, depth_range_.data());
        glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
        // A host's samplers would filter what the client's textures are read as. Not restored, as client.h says.
        glBindSamplers(0, 16, nullptr);
        // The client's transfers are of its own memory.
        glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
        glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    }
    ~HostGlState() {
        for (std::size_t i = 0; i < switches_.size(); ++i)
            on_[i] == GL_TRUE ? glEnable(switches_[i]) : glDisable(switches_[i]);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, number(GL_DRAW_FRAMEBUFFER_BINDING));
        glBindFramebuffer(GL_READ_FRAMEBUFFER, number(GL_READ_FRAMEBUFFER_BINDING));
        glUseProgram(number(GL_CURRENT_PROGRAM));
        glBindVertexArray(number(GL_VERTEX_ARRAY_BINDING));
        glActiveTexture(number(GL_ACTIVE_TEXTURE));
        glClipControl(number(GL_CLIP_ORIGIN), number(GL_CLIP_DEPTH_MODE));
        glDepthFunc(number(GL_DEPTH_FUNC));
        glFrontFace(number(GL_FRONT_FACE));
        glPixelStorei(GL_PACK_ALIGNMENT, GLint(number(GL_PACK_ALIGNMENT)));
        glPixelStorei(GL_UNPACK_ALIGNMENT, GLint(number(GL_UNPACK_ALIGNMENT)));
        glBindBuffer(GL_PIXEL_PACK_BUFFER, number(GL_PIXEL_PACK_BUFFER_BINDING));
        glBindBuffer(GL_PIXEL_UNPACK_BUFFER, number(GL_PIXEL_UNPACK_BUFFER_BINDING));
        glPolygonMode(GL_FRONT_AND_BACK, GLenum(polygon_mode_[0]));
        glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
        glScissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
        glColorMask(colour_mask_[0], colour_mask_[1], colour_mask_[2], colour_mask_[3]);
        glDepthRange(depth_range_[0], depth_range_[1]);
        glDepthMask(depth_mask_);
    }
    HostGlState(const HostGlState&) = delete;
    HostGlState& operator=(const HostGlState&) = delete;

private:
    static constexpr std::array<GLenum, 12> switches_ = {
        GL_BLEND,        GL_CULL_FACE,        GL_DEPTH_CLAMP,       GL_DEPTH_TEST,
        GL_DITHER,       GL_FRAMEBUFFER_SRGB, GL_COLOR_LOGIC_OP,    GL_POLYGON_OFFSET_FILL,
        GL_SCISSOR_TEST, GL_STENCIL_TEST,     GL_PRIMITIVE_RESTART, GL_RASTERIZER_DISCARD};
    static constexpr std::array<GLenum, 13> numbers_ = {GL_DRAW_FRAMEBUFFER_BINDING,
                                                        GL_READ_FRAMEBUFFER_BINDING,
                                                        GL_CURRENT_PROGRAM,
                                                        GL_VERTEX_ARRAY_BINDING,
                                                        GL_ACTIVE_TEXTURE,
                                                        GL_CLIP_ORIGIN,
                                                        GL_CLIP_DEPTH_MODE,
                                                        GL_DEPTH_FUNC,
                                                        GL_FRONT_FACE,
                                                        GL_PACK_ALIGNMENT,
                                                        GL_UNPACK_ALIGNMENT,
                                                        GL_PIXEL_PACK_BUFFER_BINDING,
                                                        GL_PIXEL_UNPACK_BUFFER_BINDING};
    /// One of them, as it was.
    GLuint number(GLenum name) const {
        return GLuint(values_[std::size_t(std::ranges::find(numbers_, name) - numbers_.begin())]);
    }

    std::array<GLboolean, switches_.size()> on_{};
    std::array<GLint, numbers_.size()> values_{};
    std::array<GLint, 2> polygon_mode_{};
    std::array<GLint, 4> viewport_{}, scissor_{};
    std::array<GLboolean, 4> colour_mask_{};
    std::array<GLdouble, 2> depth_range_{};
    GLboolean depth_mask_ = GL_TRUE;
};

}  // namespace equistream::gl
