#include "resample.h"

#include <client/gpu/drawing_state.h>
#include <client/warp/engine.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

/// See pixel_list.glsl: work groups, and the count. Of two eyes of 4096x4096 the pixels alone are all that a buffer of
/// 128 MiB holds, which is as much as some drivers have.
using ListHead = std::array<GLuint, 4>;
constexpr ListHead nothing_listed = {0, 1, 1, 0};
constexpr GLuint list_unit = 8, head_unit = 9;

}  // namespace

PixelList::PixelList()
    : groups_("pixel_list_groups.glsl"), head_(make_buffer(sizeof(ListHead), GL_DYNAMIC_STORAGE_BIT)) {}

void PixelList::size_for(std::size_t pixels) {
    if (pixels <= pixels_)
        return;
    list_ = make_buffer(pixels * sizeof(GLuint), 0);
    pixels_ = pixels;
}

void PixelList::start() const {
    // The last list was written by a shader.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glNamedBufferSubData(head_.name(), 0, sizeof nothing_listed, nothing_listed.data());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, head_unit, head_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, list_unit, list_.name());
}

void PixelList::dispatch(const Program& program) const {
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    groups_.dispatch({1, 1});
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    program.dispatch_indirect(head_.name(), 0);
}

namespace {

std::vector<std::string> defines(ResampleRule rule) {
    return {rule == ResampleRule::direction ? "BY_SURFACE false" : "BY_SURFACE true",
            rule == ResampleRule::any ? "ONLY_SEEN false" : "ONLY_SEEN true"};
}

}  // namespace

Resample::Resample(ResampleRule rule, double error_budget_px)
    : rule_(rule), error_budget_px_(error_budget_px),
      first_({{GL_VERTEX_SHADER, "resample_vertex.glsl"}, {GL_FRAGMENT_SHADER, "resample_first.glsl"}}, defines(rule)),
      listed_("resample.glsl", defines(rule)), no_vertices_(make_vertex_array()) {}

void Resample::draw_first(const EyeTargets& targets) const {
    write_all_pixels();
    glBindFramebuffer(GL_FRAMEBUFFER, targets.framebuffer());
    glViewport(0, 0, targets.size().width, targets.size().height);
    glBindVertexArray(no_vertices_.name());
    first_.use();
    glDrawArraysInstanced(GL_TRIANGLES, 0, 3, targets.eyes());
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

void Resample::reproject(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes,
                         const EyeDepth& depth, const EyeTargets& targets) {
    assert(int(eyes.size()) == targets.eyes());
    assert(rule_ != ResampleRule::seen || source.depth() != 0 ||
           std::ranges::all_of(eyes, [&](const EyeView& eye) { return same_position(view.pose, eye.pose); }));
    const Size size = targets.size();
    list_.size_for(std::size_t(size.width) * std::size_t(size.height) * eyes.size());
    eyes_.set(view, eyes, error_budget_px_);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, eyes_.name());
    list_.start();
    glBindTextureUnit(0, source.colour());
    glBindTextureUnit(1, source.depth());
    glBindTextureUnit(2, depth.texture);
    if (rule_ != ResampleRule::direction) {
        first_.set("eye_size", glm::ivec2(size.width, size.height));
        for (const Program* program : {&first_, &listed_})
            program->set("inverse_depth_scale", depth.scale);
    }
    draw_first(targets);
    glBindImageTexture(0, targets.colour(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
    glBindImageTexture(1, targets.origin(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    list_.dispatch(listed_);
    finish_pictures();
}

}  // namespace equistream::gl
