#include "motion_view.h"

#include <cassert>

namespace equistream::gl {

MotionView::MotionView() : program_("motion_view.glsl") {}

void MotionView::find(const SourceView& source, const PictureExtrapolator& extrapolator, std::span<const EyeView> eyes,
                      const EyeDepth& depth) {
    assert(!eyes.empty());
    const Size size{eyes.front().camera.width, eyes.front().camera.height};
    if (!(size == size_) || int(eyes.size()) != eyes_) {
        motion_ = make_layered_texture(size, int(eyes.size()), GL_RGBA16F);
        size_ = size;
        eyes_ = int(eyes.size());
    }
    blocks_.set(source, eyes);
    extrapolator.bind();
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    glBindTextureUnit(0, extrapolator.regions());
    glBindTextureUnit(2, depth.texture);
    glBindImageTexture(0, motion_.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA16F);
    program_.set("has_depth", int(depth.texture != 0));
    program_.set("inverse_depth_scale", depth.scale);
    program_.dispatch(size_, eyes_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

}  // namespace equistream::gl
