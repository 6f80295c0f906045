#include "spread.h"

#include "../push_pull_pyramid.h"

#include <array>
#include <cassert>

namespace equistream::gl {

namespace {

/// As spread_lists.glsl has them.
using Counts = std::array<GLuint, most_eyes>;
constexpr std::size_t lists = 2;

}  // namespace

Spread::Spread() : list_({{GL_COMPUTE_SHADER, "list_gaps.glsl"}}), spread_({{GL_COMPUTE_SHADER, "spread.glsl"}}) {}

void Spread::size_for(const EyeTargets& targets) {
    if (targets.size() == size_ && targets.eyes() == eyes_)
        return;
    size_ = targets.size();
    eyes_ = targets.eyes();
    const std::size_t pixels = std::size_t(size_.width) * std::size_t(size_.height) * std::size_t(eyes_);
    states_ = make_buffer(pixels * sizeof(GLuint), 0);
    lists_ = make_buffer(sizeof(Counts) + lists * pixels * sizeof(GLuint), GL_DYNAMIC_STORAGE_BIT);
}

void Spread::spread(const GapTargets& to, bool across_surfaces) const {
    constexpr Counts nothing{};
    // A shader wrote the last ones.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glNamedBufferSubData(lists_.name(), 0, sizeof nothing, nothing.data());
    to.gaps.dispatch(list_, GapTiles::List::with_gaps_or_beside, PullPyramid::tile_levels);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    spread_.set("across_surfaces", int(across_surfaces));
    spread_.use();
    glDispatchCompute(GLuint(to.targets.eyes()), 1, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                    GL_SHADER_STORAGE_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
}

void Spread::fill(const GapTargets& to) {
    assert(int(to.eyes.size()) == to.targets.eyes());
    size_for(to.targets);
    std::array<Pose, most_eyes> own;
    for (std::size_t i = 0; i < to.eyes.size(); ++i)
        own[i] = to.eyes[i].pose;
    blocks_.set(std::span(own).first(to.eyes.size()), 0, to.eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    to.gaps.bind();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, states_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, lists_.name());
    glBindTextureUnit(2, to.depth.texture);
    glBindTextureUnit(3, to.targets.origin());
    glBindImageTexture(0, to.targets.colour(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_RGBA8);
    glBindImageTexture(1, to.targets.origin(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    spread_.set("inverse_depth_scale", to.depth.scale);
    spread_.set("has_depth", int(to.depth.texture != 0));
    spread(to, false);
    if (to.depth.texture != 0)
        spread(to, true);
}

}  // namespace equistream::gl
