#include "eye_depth_finder.h"

#include <client/warp/engine.h>
#include <client/warp/source_depth_engine.h>
#include <client/warp/source_lattice.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

namespace equistream::gl {

bool LatticeTextures::set(const Camera& camera) {
    if (camera_ && same_camera(camera, *camera_))
        return true;
    const LatticeAngles angles(camera);
    const std::size_t width = std::max(angles.column_a.size(), angles.row_a.size());
    angles_ = make_texture({int(width), 2}, GL_RG32F);
    const auto upload = [&](int row, const std::vector<float>& a, const std::vector<float>& b) {
        std::vector<float> both(2 * a.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            both[2 * i] = a[i];
            both[2 * i + 1] = b.empty() ? 0 : b[i];
        }
        glTextureSubImage2D(angles_.name(), 0, 0, row, GLsizei(a.size()), 1, GL_RG, GL_FLOAT, both.data());
    };
    upload(0, angles.column_a, angles.column_b);
    upload(1, angles.row_a, angles.row_b);
    camera_ = camera;
    return false;
}

void LatticeTextures::bind() const {
    glBindTextureUnit(5, angles_.name());
}

namespace {

/// As source_block.glsl has it.
struct SourceBlock {
    std::array<float, 4> cone;
    std::array<float, 2> inverses;
    float sine;
    GLuint sum;
};

}  // namespace

SourceBlocks::SourceBlocks() : pass_("source_blocks.glsl") {}

void SourceBlocks::size_for(const Camera& camera) {
    constexpr int side = LatticeBlock::side;
    const int columns = width_of(camera) + (columns_close(camera) ? 0 : 1), rows = height_of(camera) + 1;
    const Size grid{(columns + side - 1) / side, (rows + side - 1) / side};
    if (grid == grid_)
        return;
    blocks_ = make_buffer(std::size_t(grid.width) * std::size_t(grid.height) * sizeof(SourceBlock), 0);
    grid_ = grid;
}

void SourceBlocks::find() const {
    bind(pass_, 0);
    pass_.use();
    glDispatchCompute(GLuint(grid_.width), GLuint(grid_.height), 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void SourceBlocks::bind(const Program& program, GLuint binding) const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, blocks_.name());
    program.set("block_grid", glm::ivec2(grid_.width, grid_.height));
}

void EyeDepthFinder::bind(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) {
    assert((source.depth() != 0 || !traits_.needs_depth) && !eyes.empty() && eyes.size() <= std::size_t(max_eyes));
    eye_blocks_.set(view, eyes, traits_.error_budget_px);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, eye_blocks_.name());
    glBindTextureUnit(1, source.depth());
    lattice_.bind();
}

bool EyeDepthFinder::size_for(Size size, int eyes) {
    if (size == size_ && eyes == eyes_)
        return true;
    depth_ = make_layered_texture(size, eyes, GL_R32F);
    size_ = size;
    eyes_ = eyes;
    return false;
}

void EyeDepthFinder::bind_depth() const {
    glBindImageTexture(0, depth_.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
}

void EyeDepthFinder::forget_gaps(const EyeTargets& targets) const {
    assert(targets.size() == size_ && targets.eyes() == eyes_);
    glBindTextureUnit(3, targets.origin());
    bind_depth();
    forget_gaps_.dispatch(size_, eyes_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
}

ProxySphereDepth::ProxySphereDepth(const EngineOptions& options)
    : EyeDepthFinder(options, {.needs_depth = false, .only_seen = false, .is_known = false}),
      pass_("proxy_sphere_depth.glsl") {}

void ProxySphereDepth::find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) {
    if (radius_m_ == 0)
        radius_m_ = float(proxy_radius_m(view, options_));
    size_for({eyes.front().camera.width, eyes.front().camera.height}, int(eyes.size()));
    bind(view, source, eyes);
    bind_depth();
    pass_.set("radius_m", radius_m_);
    pass_.dispatch(size_, eyes_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

std::unique_ptr<EyeDepthFinder> make_proxy_sphere_depth(const EngineOptions& options) {
    return std::make_unique<ProxySphereDepth>(options);
}

}  // namespace equistream::gl
