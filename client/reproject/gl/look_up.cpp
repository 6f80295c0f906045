#include "look_up.h"

#include "../eye_rays.h"
#include "../hiding_surface.h"
#include "../warp.h"

#include <equistream/bound.h>
#include <equistream/formatted.h>
#include <equistream_client/engine.h>

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cassert>
#include <cmath>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

/// As std140 has it.
struct EyeBlock {
    glm::vec4 corner, right, down, eye, eye_own_axes;
    glm::mat4 source_from_eye;
    glm::vec4 view, agreement;
};

glm::vec4 padded(Vec3f v) {
    return {v.x, v.y, v.z, 0};
}

std::vector<std::string> defines(bool surface) {
    std::vector<std::string> all = grid_defines();
    all.insert(
        all.end(),
        {formatted("BY_SURFACE %s", surface ? "true" : "false"), formatted("MOST_EYES %d", most_eyes),
         formatted("FAR_DISTANCE_M %.9g", double(far_distance_m)), formatted("LEAST_BEHIND %.9g", double(least_behind)),
         formatted("MOST_BEND %.9g", double(most_bend)), formatted("LEAST_WEIGHT %.9g", double(least_weight)),
         formatted("ORIGIN_SOURCE %du", int(PixelOrigin::source)), formatted("ORIGIN_GAP %du", int(PixelOrigin::gap))});
    return all;
}

}  // namespace

LookUp::LookUp(bool surface, double error_budget_px)
    : surface_(surface), error_budget_px_(error_budget_px),
      program_({{GL_COMPUTE_SHADER, "look_up.glsl"}}, defines(surface)),
      eyes_(make_buffer(most_eyes * sizeof(EyeBlock), GL_DYNAMIC_STORAGE_BIT)) {}

void LookUp::reproject(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes,
                       const EyeDepth& depth, const EyeTargets& targets) {
    assert(int(eyes.size()) == targets.eyes());
    std::array<EyeBlock, most_eyes> blocks;
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        const EyeRays rays(eyes[i].camera, eyes[i].pose, view.pose);
        const bool moved = surface_ && !same_position(view.pose, eyes[i].pose);
        assert(!moved || source.depth() != 0);
        const double tolerance_rad = 4 * error_budget_px_ * error_budget_rad(eyes[i].camera.focal_px());
        blocks[i] = {padded(rays.corner()),
                     padded(rays.right()),
                     padded(rays.down()),
                     padded(rays.eye()),
                     padded(rays.eye_own_axes()),
                     glm::mat4(rays.source_from_eye()),
                     {rays.focal_px(), rays.centre_x(), rays.centre_y(), moved ? 1.0f : 0.0f},
                     {std::max(float(view.box_radius_m), rays.distance_m()), std::sin(tolerance_rad), 0, 0}};
    }
    glNamedBufferSubData(eyes_.name(), 0, GLsizeiptr(eyes.size() * sizeof(EyeBlock)), blocks.data());
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
