#include "wide_gaps.h"

#include "../push_pull_pyramid.h"

#include <string>
#include <vector>

namespace equistream::gl {

namespace {

Program made(const char* pass) {
    return Program({{GL_COMPUTE_SHADER, "wide_gaps_pass.glsl"}}, std::vector<std::string>{pass});
}

}  // namespace

WideGaps::WideGaps() : start_(made("START")), join_(made("JOIN")), mark_(made("MARK")) {}

void WideGaps::size_for(const EyeTargets& targets) {
    if (targets.size() == size_ && targets.eyes() == eyes_)
        return;
    size_ = targets.size();
    eyes_ = targets.eyes();
    const std::size_t pixels = std::size_t(size_.width) * std::size_t(size_.height) * std::size_t(eyes_);
    parents_ = make_buffer(pixels * sizeof(GLuint), 0);
    wide_roots_ = make_buffer((pixels + 31) / 32 * sizeof(GLuint), 0);
}

void WideGaps::bind() const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, parents_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, wide_roots_.name());
}

void WideGaps::find(const GapTiles& gaps, const EyeTargets& targets, int side) {
    size_for(targets);
    const GLuint nobody = 0;
    // A shader wrote what is there.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glClearNamedBufferData(wide_roots_.name(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &nobody);
    gaps.bind();
    bind();
    glBindTextureUnit(3, targets.origin());
    mark_.set("side", side);
    for (const Program* program : {&start_, &join_, &mark_}) {
        gaps.dispatch(*program, GapTiles::List::with_gaps, PullPyramid::tile_levels);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
}

}  // namespace equistream::gl
