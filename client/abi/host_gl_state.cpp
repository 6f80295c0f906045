#include "host_gl_state.h"

namespace equistream::gl {

HostGlState::HostGlState() {
    for (std::size_t i = 0; i < switches_.size(); ++i)
        on_[i] = glIsEnabled(switches_[i]);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_framebuffer_);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read_framebuffer_);
    glGetIntegerv(GL_CURRENT_PROGRAM, &program_);
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array_);
    glGetIntegerv(GL_ACTIVE_TEXTURE, &active_texture_);
    glGetIntegerv(GL_CLIP_ORIGIN, &clip_origin_);
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &clip_depth_);
    glGetIntegerv(GL_DEPTH_FUNC, &depth_function_);
    glGetIntegerv(GL_FRONT_FACE, &front_face_);
    glGetIntegerv(GL_PACK_ALIGNMENT, &pack_alignment_);
    glGetIntegerv(GL_UNPACK_ALIGNMENT, &unpack_alignment_);
    glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &pixel_pack_);
    glGetIntegerv(GL_PIXEL_UNPACK_BUFFER_BINDING, &pixel_unpack_);
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

HostGlState::~HostGlState() {
    for (std::size_t i = 0; i < switches_.size(); ++i)
        on_[i] == GL_TRUE ? glEnable(switches_[i]) : glDisable(switches_[i]);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, GLuint(draw_framebuffer_));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, GLuint(read_framebuffer_));
    glUseProgram(GLuint(program_));
    glBindVertexArray(GLuint(vertex_array_));
    glActiveTexture(GLenum(active_texture_));
    glClipControl(GLenum(clip_origin_), GLenum(clip_depth_));
    glDepthFunc(GLenum(depth_function_));
    glFrontFace(GLenum(front_face_));
    glPixelStorei(GL_PACK_ALIGNMENT, pack_alignment_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, unpack_alignment_);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, GLuint(pixel_pack_));
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, GLuint(pixel_unpack_));
    glPolygonMode(GL_FRONT_AND_BACK, GLenum(polygon_mode_[0]));
    glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    glScissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
    glColorMask(colour_mask_[0], colour_mask_[1], colour_mask_[2], colour_mask_[3]);
    glDepthRange(depth_range_[0], depth_range_[1]);
    glDepthMask(depth_mask_);
}

}  // namespace equistream::gl
