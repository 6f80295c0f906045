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

std::vector<std::string> defines() {
    std::vector<std::string> all = DepthPass::geometry_defines();
    all.push_back(formatted("EDGE %.9g", edge_tolerance));
    return all;
}

}  // namespace

SphereDepth::SphereDepth(double box_radius_m, double error_rad)
    : box_radius_m_(float(box_radius_m)), error_(float(std::sin(error_rad))),
      program_({{GL_COMPUTE_SHADER, "sphere_depth.glsl"}}, defines()),
      views_(make_buffer(most_views * sizeof(FlatView), GL_DYNAMIC_STORAGE_BIT)) {}

void SphereDepth::resolve(const DepthPass& pass, int first_layer, const SphereViews& views, const Pose& source_pose,
                          SourceTextures& source) {
    assert(views.views.size() > 0 && views.views.size() <= most_views);
    std::array<FlatView, most_views> blocks;
    for (std::size_t i = 0; i < views.views.size(); ++i) {
        const DepthViewpoint& view = views.views[i];
        const glm::dquat turn = glm::conjugate(view.pose.orientation) * source_pose.orientation;
        blocks[i] = {glm::mat4(glm::mat4_cast(turn)),
                     {view.camera.width, view.camera.height, view.camera.focal_px(), first_layer + int(i)}};
    }
    glNamedBufferSubData(views_.name(), 0, GLsizeiptr(views.views.size() * sizeof(FlatView)), blocks.data());
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, views_.name());
    pass.geometry().bind();
    glBindTextureUnit(0, pass.texture());
    glBindTextureUnit(1, pass.triangles());
    glBindImageTexture(0, source.depth_to_write(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    program_.set("centre_world", glm::vec3(source_pose.position_m));
    program_.set("world_from_source", glm::mat3(glm::mat3_cast(source_pose.orientation)));
    program_.set("view_count", int(views.views.size()));
    program_.set("box_radius_m", box_radius_m_);
    program_.set("error", error_);
    program_.set("inverse_depth_scale", DepthPass::inverse_scale());
    program_.set("first", glm::ivec2(views.samples.first_column, views.samples.first_row));
    program_.set("wanted", glm::ivec2(views.samples.columns, views.samples.rows));
    program_.dispatch({views.samples.columns, views.samples.rows});
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

}  // namespace equistream::gl
