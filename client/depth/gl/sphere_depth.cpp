#include "sphere_depth.h"

#include <equistream/formatted.h>

#include <glm/gtc/quaternion.hpp>

#include <array>
#include <cassert>
#include <cmath>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

/// As std140 has it.
struct FlatView {
    glm::mat4 view_from_source;
    glm::vec4 size;
};

/// In barycentric coordinates, so that no ray slips through between two triangles.
constexpr double edge_tolerance = 1e-5;

std::vector<std::string> defines(std::size_t views) {
    std::vector<std::string> all = DepthPass::geometry_defines();
    all.push_back(formatted("EDGE %.9g", edge_tolerance));
    all.push_back("VIEWS " + std::to_string(views));
    return all;
}

}  // namespace

SphereDepth::Passes::Passes(std::size_t views)
    : first({{GL_COMPUTE_SHADER, "sphere_depth_first.glsl"}}, defines(views)),
      listed({{GL_COMPUTE_SHADER, "sphere_depth.glsl"}}, defines(views)) {}

SphereDepth::SphereDepth(double box_radius_m, double error_rad)
    : box_radius_m_(float(box_radius_m)), error_(float(std::sin(error_rad))), one_view_(1),
      faces_(SourceViewpoints::most),
      views_(make_buffer(SourceViewpoints::most * sizeof(FlatView), GL_DYNAMIC_STORAGE_BIT)) {}

void SphereDepth::resolve(const DepthPass& pass, int first_layer, const SphereViews& views, const Pose& source_pose,
                          SourceTextures& source) {
    assert(views.views.size() > 0);
    std::array<FlatView, SourceViewpoints::most> blocks{};  // no sample lies in those that are not there
    for (std::size_t i = 0; i < views.views.size(); ++i) {
        const DepthViewpoint& view = views.views[i];
        const glm::dquat turn = glm::conjugate(view.pose.orientation) * source_pose.orientation;
        blocks[i] = {glm::mat4(glm::mat4_cast(turn)),
                     {view.camera.width, view.camera.height, view.camera.focal_px(), first_layer + int(i)}};
    }
    glNamedBufferSubData(views_.name(), 0, sizeof blocks, blocks.data());
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, views_.name());
    pass.geometry().bind();
    glBindTextureUnit(0, pass.texture());
    glBindTextureUnit(1, pass.triangles());
    glBindImageTexture(0, source.depth_to_write(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    const Passes& passes = views.views.size() == 1 ? one_view_ : faces_;
    for (const Program* program : {&passes.first, &passes.listed})
        program->set("inverse_depth_scale", DepthPass::inverse_scale());
    passes.first.set("box_radius_m", box_radius_m_);
    passes.first.set("error", error_);
    passes.first.set("first", glm::ivec2(views.samples.first_column, views.samples.first_row));
    passes.first.set("wanted", glm::ivec2(views.samples.columns, views.samples.rows));
    passes.listed.set("centre_world", glm::vec3(source_pose.position_m));
    passes.listed.set("world_from_source", glm::mat3(glm::mat3_cast(source_pose.orientation)));
    list_.size_for(std::size_t(source.size().width) * std::size_t(source.size().height));
    list_.start();
    passes.first.dispatch({views.samples.columns, views.samples.rows});
    list_.dispatch(passes.listed);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

}  // namespace equistream::gl
