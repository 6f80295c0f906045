#include "gather_depth.h"

#include <equistream/bound.h>

#include <cmath>
#include <string>
#include <variant>
#include <vector>

namespace equistream::gl {

namespace {

/// Of tiles of an eye.
constexpr int tile_side = 32;
/// Where searches of one pixel begin, from the farthest to the nearest that its tile may show. From fewer, one side of
/// silhouettes is missed more often.
constexpr int seeds = 9;

std::vector<std::string> defines() {
    return {"GATHER_TILE_SIDE " + std::to_string(tile_side), "GATHER_SEEDS " + std::to_string(seeds)};
}

}  // namespace

GatherDepth::GatherDepth(const EngineOptions& options)
    : EyeDepthFinder(options), gather_({{GL_COMPUTE_SHADER, "gather.glsl"}}, defines()) {}

void GatherDepth::find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) {
    const PerspectiveCamera& camera = eyes.front().camera;
    const Size size{camera.width, camera.height};
    layers_.size_for(size, int(eyes.size()));
    knows_blocks_ = lattice_.set(view.camera) && knows_blocks_;
    blocks_.size_for(view.camera);
    bind(view, source, eyes);
    if (!knows_blocks_)
        blocks_.find();
    knows_blocks_ = true;
    blocks_.bind(gather_, 0);
    const double share_rad = options_.mesh_share * error_budget_rad(camera.focal_px(), options_.error_budget_px);
    const double pixel_rad = std::visit([](const auto& c) { return c.pixel_angle_rad(); }, view.camera);
    gather_.set("finding", glm::vec2(std::sin(share_rad), pixel_rad));
    gather_.use();
    layers_.bind(0);
    glDispatchCompute(GLuint((size.width + tile_side - 1) / tile_side),
                      GLuint((size.height + tile_side - 1) / tile_side), GLuint(eyes.size()));
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

}  // namespace equistream::gl
