#include "cluster_culling.h"

#include "depth_pass.h"

#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <utility>
#include <vector>

namespace equistream::gl {

namespace {

/// Powers of two, so that every texel of a level lies in one of the next.
int side_for(int texels) {
    const int blocks = (texels + DepthPyramid::block - 1) / DepthPyramid::block;
    return int(std::bit_ceil(unsigned(blocks)));
}

}  // namespace

DepthPyramid::DepthPyramid(std::span<const std::string> defines) : program_("depth_pyramid.glsl", defines) {}

void DepthPyramid::size_for(Size size, int layers) {
    const Size texels{side_for(size.width), side_for(size.height)};
    const int level_count = std::bit_width(unsigned(std::max(texels.width, texels.height)));
    levels_ = make_layered_texture(texels, layers, GL_R32F, level_count);
    size_ = texels;
    level_count_ = level_count;
}

void DepthPyramid::build(const Texture& depth, int layers) const {
    Size size = size_;
    for (int level = 0; level < level_count_; ++level) {
        glBindTextureUnit(0, level == 0 ? depth.name() : levels_.name());
        glBindImageTexture(0, levels_.name(), level, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
        program_.set("finer_level", level - 1);
        program_.dispatch(size, layers);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        size = {std::max(1, size.width / 2), std::max(1, size.height / 2)};
    }
}

namespace {

/// As the shader has them.
struct Command {
    std::uint32_t count, instances, first_index, base_vertex, base_instance;
};
struct Counts {
    std::uint32_t records, triangles, opaque[2], masked[2];
};

constexpr GLuint group_items = 64;
constexpr std::size_t max_rounds = ClusterCulling::rounds(Culling::hidden);

std::vector<std::string> defines() {
    std::vector<std::string> all = DepthPass::geometry_defines();
    all.push_back(formatted("PYRAMID_BLOCK %d", DepthPyramid::block));
    all.push_back(formatted("CULL_NOTHING %d", int(Culling::nothing)));
    all.push_back(formatted("CULL_HIDDEN %d", int(Culling::hidden)));
    return all;
}

}  // namespace

ClusterCulling::ClusterCulling(const SceneGeometry& geometry)
    : geometry_(geometry), program_("cull.glsl", defines()), pyramid_(defines()),
      counts_(make_buffer(sizeof(Counts), GL_DYNAMIC_STORAGE_BIT)),
      seen_by_(make_buffer_of(std::span<const std::uint32_t>(std::vector<std::uint32_t>(geometry.item_count(), 0)))) {}

void ClusterCulling::size_for(Size size, int layers) {
    if (layers == layers_)
        return pyramid_.size_for(size, layers);
    // In both rounds together an item is drawn once a view.
    const std::size_t most = std::size_t(geometry_.item_count()) * std::size_t(layers);
    Buffer records = make_buffer(most * record_bytes, 0),
           opaque_commands = make_buffer(max_rounds * most * sizeof(Command), 0),
           masked_commands = make_buffer(geometry_.has_masks() ? max_rounds * most * sizeof(Command) : 0, 0);
    pyramid_.size_for(size, layers);
    records_ = std::move(records);
    opaque_commands_ = std::move(opaque_commands);
    masked_commands_ = std::move(masked_commands);
    layers_ = layers;
}

void ClusterCulling::start(int views, Culling culling) {
    assert(views <= layers_);
    constexpr Counts none{};
    // The last frame's were written by a shader.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glNamedBufferSubData(counts_.name(), 0, sizeof none, &none);
    views_ = views;
    culling_ = culling;
}

void ClusterCulling::find(int round) const {
    const std::array buffers = {geometry_.items(),       geometry_.transforms(), opaque_commands_.name(),
                                masked_commands_.name(), counts_.name(),         geometry_.growth(),
                                seen_by_.name(),         records_.name(),        geometry_.instance_masks()};
    glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, GLsizei(buffers.size()), buffers.data());
    glBindTextureUnit(0, pyramid_.texture());
    program_.set("item_count", int(geometry_.item_count()));
    program_.set("view_count", views_);
    program_.set("max_draws", int(geometry_.item_count()) * layers_);
    program_.set("round", round);
    program_.set("culling", int(culling_));
    program_.use();
    glDispatchCompute((geometry_.item_count() + group_items - 1) / group_items, 1, 1);
    glMemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT);
}

void ClusterCulling::find_rest(const Texture& depth) const {
    assert(culling_ == Culling::hidden);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    pyramid_.build(depth, views_);
    find(1);
}

void ClusterCulling::draw(int round, bool masked) const {
    const std::size_t counts = masked ? offsetof(Counts, masked) : offsetof(Counts, opaque);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, masked ? masked_commands_.name() : opaque_commands_.name());
    glBindBuffer(GL_PARAMETER_BUFFER_ARB, counts_.name());
    const std::size_t most = std::size_t(geometry_.item_count()) * std::size_t(layers_);
    const std::size_t first_byte = std::size_t(round) * most * sizeof(Command);
    glMultiDrawElementsIndirectCountARB(GL_TRIANGLES, GL_UNSIGNED_INT, reinterpret_cast<const void*>(first_byte),
                                        GLintptr(counts + std::size_t(round) * sizeof(std::uint32_t)), GLsizei(most),
                                        sizeof(Command));
}

DrawnFigures ClusterCulling::drawn() const {
    Counts counts{};
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(counts_.name(), 0, sizeof counts, &counts);
    return {counts.records, counts.triangles};
}

}  // namespace equistream::gl
