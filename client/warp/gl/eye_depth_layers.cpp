#include "eye_depth_layers.h"

#include <cassert>

namespace equistream::gl {

EyeDepthLayers::EyeDepthLayers() : forget_gaps_({{GL_COMPUTE_SHADER, "forget_gaps.glsl"}}) {}

bool EyeDepthLayers::size_for(Size size, int eyes) {
    if (size == size_ && eyes == eyes_)
        return true;
    depth_ = make_layered_texture(size, eyes, GL_R32F);
    size_ = size;
    eyes_ = eyes;
    return false;
}

void EyeDepthLayers::bind(GLuint unit) const {
    glBindImageTexture(unit, depth_.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
}

void EyeDepthLayers::forget_gaps(const EyeTargets& targets) const {
    assert(targets.size() == size_ && targets.eyes() == eyes_);
    glBindTextureUnit(3, targets.origin());
    bind(0);
    forget_gaps_.dispatch(size_, eyes_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
}

}  // namespace equistream::gl
