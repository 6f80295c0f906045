#include "gap_resample.h"

#include <client/fill/push_pull_pyramid.h>

#include <cassert>

namespace equistream::gl {

GapResample::GapResample() : program_({{GL_COMPUTE_SHADER, "gap_resample.glsl"}}) {}

void GapResample::fill(const OtherPicture& from, const GapTargets& to) {
    const bool by_direction = from.textures.depth() == 0;
    if (by_direction && from.mark != PixelOrigin::small)
        return;
    blocks_.set(from.view, to.eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, from.textures.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    glBindTextureUnit(0, from.textures.colour());
    glBindTextureUnit(1, from.textures.depth());
    program_.set("by_direction", int(by_direction));
    run_gap_resample(program_, to, from.mark);
}

void run_gap_resample(const Program& program, const GapTargets& to, PixelOrigin mark) {
    assert(int(to.eyes.size()) == to.targets.eyes());
    to.gaps.bind();
    glBindTextureUnit(2, to.depth.texture);
    glBindTextureUnit(3, to.targets.origin());
    glBindTextureUnit(5, to.image_behind);
    glBindImageTexture(0, to.targets.colour(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
    glBindImageTexture(1, to.targets.origin(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    program.set("inverse_depth_scale", to.depth.scale);
    program.set("mark", int(mark));
    program.set("knows_mirrors", int(to.image_behind != 0));
    to.gaps.dispatch(program, GapTiles::List::with_gaps, PullPyramid::tile_levels);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                    GL_FRAMEBUFFER_BARRIER_BIT);
}

}  // namespace equistream::gl
