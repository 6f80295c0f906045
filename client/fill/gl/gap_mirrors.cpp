#include "gap_mirrors.h"

#include <client/fill/push_pull_pyramid.h>

#include <cassert>

namespace equistream::gl {

GapMirrors::GapMirrors() : program_({{GL_COMPUTE_SHADER, "gap_mirrors.glsl"}}) {}

GLuint GapMirrors::find(const SpecularSource& teller, const GapTargets& to) {
    assert(int(to.eyes.size()) == to.targets.eyes());
    if (!teller.tells())
        return 0;
    if (!(to.targets.size() == size_ && to.targets.eyes() == eyes_)) {
        size_ = to.targets.size();
        eyes_ = to.targets.eyes();
        image_behind_ = make_layered_texture(size_, eyes_, GL_R32F);
    }
    blocks_.set(teller.view, to.eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, teller.textures.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    to.gaps.bind();
    glBindTextureUnit(1, teller.textures.depth());
    glBindTextureUnit(2, to.depth.texture);
    glBindTextureUnit(3, to.targets.origin());
    teller.specular.bind();
    glBindImageTexture(0, to.targets.colour(), 0, GL_TRUE, 0, GL_READ_ONLY, GL_RGBA8);
    glBindImageTexture(2, image_behind_.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    program_.set("inverse_depth_scale", to.depth.scale);
    to.gaps.dispatch(program_, GapTiles::List::with_gaps, PullPyramid::tile_levels);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    return image_behind_.name();
}

}  // namespace equistream::gl
