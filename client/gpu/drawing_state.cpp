#include "drawing_state.h"

namespace equistream::gl {

namespace {

void enable(GLenum what, bool on) {
    on ? glEnable(what) : glDisable(what);
}

}  // namespace

void write_all_pixels() {
    for (const GLenum off : {GL_DEPTH_TEST, GL_STENCIL_TEST, GL_SCISSOR_TEST, GL_CULL_FACE, GL_BLEND, GL_COLOR_LOGIC_OP,
                             GL_RASTERIZER_DISCARD})
        glDisable(off);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

DrawingState::DrawingState(GLenum depth_function, Near near)
    : has_depth_test_(glIsEnabled(GL_DEPTH_TEST)), has_depth_clamp_(glIsEnabled(GL_DEPTH_CLAMP)) {
    glGetIntegerv(GL_CLIP_ORIGIN, &clip_origin_);
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &clip_depth_);
    glGetIntegerv(GL_DEPTH_FUNC, &depth_function_);
    for (const GLenum off : {GL_SCISSOR_TEST, GL_STENCIL_TEST, GL_CULL_FACE, GL_BLEND, GL_COLOR_LOGIC_OP,
                             GL_RASTERIZER_DISCARD, GL_POLYGON_OFFSET_FILL, GL_PRIMITIVE_RESTART})
        glDisable(off);
    enable(GL_DEPTH_CLAMP, near == Near::clamped);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(depth_function);
    glDepthMask(GL_TRUE);
    glDepthRangef(0, 1);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glFrontFace(GL_CCW);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
}

DrawingState::~DrawingState() {
    glClipControl(GLenum(clip_origin_), GLenum(clip_depth_));
    glDepthFunc(GLenum(depth_function_));
    enable(GL_DEPTH_TEST, has_depth_test_ == GL_TRUE);
    enable(GL_DEPTH_CLAMP, has_depth_clamp_ == GL_TRUE);
}

}  // namespace equistream::gl
