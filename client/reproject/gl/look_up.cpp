#include "look_up.h"

#include <equistream_client/engine.h>

#include <algorithm>
#include <cassert>
#include <string>
#include <vector>

namespace equistream::gl {

LookUp::LookUp(bool surface, double error_budget_px)
    : surface_(surface), error_budget_px_(error_budget_px),
      program_({{GL_COMPUTE_SHADER, "look_up.glsl"}},
               std::vector<std::string>{surface ? "BY_SURFACE true" : "BY_SURFACE false"}) {}

void LookUp::reproject(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes,
                       const EyeDepth& depth, const EyeTargets& targets) {
    assert(int(eyes.size()) == targets.eyes());
    assert(!surface_ || source.depth() != 0 ||
           std::ranges::all_of(eyes, [&](const EyeView& eye) { return same_position(view.pose, eye.pose); }));
    eyes_.set(view, eyes, error_budget_px_);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, eyes_.name());
    glBindTextureUnit(0, source.colour());
    glBindTextureUnit(1, source.depth());
    glBindTextureUnit(2, depth.texture);
    if (surface_)
        program_.set("inverse_depth_scale", depth.scale);
    glBindImageTexture(0, targets.colour(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
    glBindImageTexture(1, targets.origin(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    program_.dispatch(targets.size(), targets.eyes());
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                    GL_FRAMEBUFFER_BARRIER_BIT);
}

}  // namespace equistream::gl
