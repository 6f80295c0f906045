#include "host_gl_state.h"

#include <algorithm>
#include <cstddef>

namespace equistream::gl {

namespace {

void enable(GLenum what, GLboolean on) {
    on == GL_TRUE ? glEnable(what) : glDisable(what);
}

void enable(GLenum what, GLuint index, GLboolean on) {
    on == GL_TRUE ? glEnablei(what, index) : glDisablei(what, index);
}

}  // namespace

HostGlState::HostGlState() {
    std::ranges::transform(switches_, on_.begin(), glIsEnabled);
    for (std::size_t i = 0; i < numbers_.size(); ++i)
        glGetIntegerv(numbers_[i], &values_[i]);
    glGetIntegerv(GL_POLYGON_MODE, polygon_mode_.data());
    glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
    for (GLuint i = 0; i < viewport_count; ++i) {
        glGetFloati_v(GL_VIEWPORT, i, &viewports_[4 * i]);
        glGetDoublei_v(GL_DEPTH_RANGE, i, &depth_ranges_[2 * i]);
        scissors_[i] = glIsEnabledi(GL_SCISSOR_TEST, i);
    }
    for (GLuint i = 0; i < draw_buffer_count; ++i) {
        glGetBooleani_v(GL_COLOR_WRITEMASK, i, &colour_masks_[4 * i]);
        blends_[i] = glIsEnabledi(GL_BLEND, i);
    }
    for (GLuint i = 0; i < clip_plane_count; ++i) {
        clips_[i] = glIsEnabled(GL_CLIP_DISTANCE0 + i);
        glDisable(GL_CLIP_DISTANCE0 + i);
    }
    for (std::size_t i = 0; i < buffers_.size(); ++i) {
        glGetIntegerv(buffers_[i].binding, &bound_[i]);
        glBindBuffer(buffers_[i].target, 0);
    }
    for (std::size_t i = 0; i < pixel_stores_.size(); ++i) {
        glGetIntegerv(pixel_stores_[i].name, &stored_[i]);
        glPixelStorei(pixel_stores_[i].name, pixel_stores_[i].initial);
    }
    // A host's samplers would filter what the client's textures are read as. Not restored, as client.h says.
    glBindSamplers(0, 16, nullptr);
}

HostGlState::~HostGlState() {
    for (std::size_t i = 0; i < switches_.size(); ++i)
        enable(switches_[i], on_[i]);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, number(GL_DRAW_FRAMEBUFFER_BINDING));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, number(GL_READ_FRAMEBUFFER_BINDING));
    glUseProgram(number(GL_CURRENT_PROGRAM));
    glBindVertexArray(number(GL_VERTEX_ARRAY_BINDING));
    glClipControl(number(GL_CLIP_ORIGIN), number(GL_CLIP_DEPTH_MODE));
    glCullFace(number(GL_CULL_FACE_MODE));
    glDepthFunc(number(GL_DEPTH_FUNC));
    glFrontFace(number(GL_FRONT_FACE));
    glPolygonMode(GL_FRONT_AND_BACK, GLenum(polygon_mode_[0]));
    glDepthMask(depth_mask_);
    glViewportArrayv(0, viewport_count, viewports_.data());
    glDepthRangeArrayv(0, viewport_count, depth_ranges_.data());
    for (GLuint i = 0; i < viewport_count; ++i)
        enable(GL_SCISSOR_TEST, i, scissors_[i]);
    for (GLuint i = 0; i < draw_buffer_count; ++i) {
        const GLboolean* const mask = &colour_masks_[4 * i];
        glColorMaski(i, mask[0], mask[1], mask[2], mask[3]);
        enable(GL_BLEND, i, blends_[i]);
    }
    for (GLuint i = 0; i < clip_plane_count; ++i)
        enable(GL_CLIP_DISTANCE0 + i, clips_[i]);
    for (std::size_t i = 0; i < buffers_.size(); ++i)
        glBindBuffer(buffers_[i].target, GLuint(bound_[i]));
    for (std::size_t i = 0; i < pixel_stores_.size(); ++i)
        glPixelStorei(pixel_stores_[i].name, stored_[i]);
}

GLuint HostGlState::number(GLenum name) const {
    return GLuint(values_[std::size_t(std::ranges::find(numbers_, name) - numbers_.begin())]);
}

}  // namespace equistream::gl
