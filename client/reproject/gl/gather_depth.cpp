#include "gather_depth.h"

#include <equistream/bound.h>

#include <glm/vec4.hpp>

#include <cmath>
#include <string>
#include <variant>
#include <vector>

namespace equistream::gl {

namespace {

/// Sides of blocks of the source and of tiles of an eye.
constexpr int block_side = 32, tile_side = 32, block_group = 32;
/// Where searches of one pixel begin, from the farthest to the nearest that its tile may show. From fewer, one side of
/// silhouettes is missed more often.
constexpr int seeds = 9;

/// As gather_block.glsl has it.
struct GatherBlock {
    glm::vec4 cone, inverse;
};

std::vector<std::string> defines() {
    return {"GATHER_BLOCK_SIDE " + std::to_string(block_side), "GATHER_TILE_SIDE " + std::to_string(tile_side),
            "GATHER_BLOCK_GROUP " + std::to_string(block_group), "GATHER_SEEDS " + std::to_string(seeds)};
}

Size tiles_of(Size size, int side) {
    return {(size.width + side - 1) / side, (size.height + side - 1) / side};
}

}  // namespace

GatherDepth::GatherDepth(const EngineOptions& options)
    : EyeDepthFinder(options), find_blocks_({{GL_COMPUTE_SHADER, "gather_blocks.glsl"}}, defines()),
      gather_({{GL_COMPUTE_SHADER, "gather.glsl"}}, defines()) {}

void GatherDepth::find_blocks() {
    const Size grid = tiles_of({lattice_.size().width + 1, lattice_.size().height + 1}, block_side);
    if (!(grid == block_grid_)) {
        blocks_ = make_buffer(std::size_t(grid.width) * std::size_t(grid.height) * sizeof(GatherBlock), 0);
        block_grid_ = grid;
    }
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, blocks_.name());
    find_blocks_.use();
    glDispatchCompute(GLuint(grid.width), GLuint(grid.height), 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    knows_blocks_ = true;
}

void GatherDepth::find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) {
    const PerspectiveCamera& camera = eyes.front().camera;
    const Size size{camera.width, camera.height};
    layers_.size_for(size, int(eyes.size()));
    knows_blocks_ = lattice_.set(view.camera) && knows_blocks_;
    bind(view, source, eyes);
    if (!knows_blocks_)
        find_blocks();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, blocks_.name());
    const double share_rad = options_.mesh_share * error_budget_rad(camera.focal_px(), options_.error_budget_px);
    const double pixel_rad = std::visit([](const auto& c) { return c.pixel_angle_rad(); }, view.camera);
    gather_.set("block_count", block_grid_.width * block_grid_.height);
    gather_.set("finding", glm::vec2(std::sin(share_rad), pixel_rad));
    gather_.use();
    layers_.bind(0);
    const Size tiles = tiles_of(size, tile_side);
    glDispatchCompute(GLuint(tiles.width), GLuint(tiles.height), GLuint(eyes.size()));
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

}  // namespace equistream::gl
