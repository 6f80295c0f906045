#include "mesh_depth.h"

#include "../source_lattice.h"

#include <equistream/bound.h>
#include <equistream/error.h>

#include <gl/drawing_state.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

/// As mesh_lists.glsl has them.
struct Draw {
    GLuint vertices = 0, instances = 0, first_vertex = 0, first_instance = 0;
};
struct ListsHead {
    std::array<Draw, 3> draws;
    std::array<GLuint, 4> large_groups = {0, 1, 1, 0};
};

/// Of the depth buffer alone: what is nearer keeps its order no more, and its distance all the same.
const std::vector<std::string> defines = {"NEAR_PLANE_M 1e-3"};

Texture uploaded_angles(const Camera& camera) {
    const LatticeAngles angles(camera);
    const std::size_t width = std::max(angles.column_a.size(), angles.row_a.size());
    Texture texture = make_texture({int(width), 2}, GL_RG32F);
    const auto upload = [&](int row, const std::vector<float>& a, const std::vector<float>& b) {
        std::vector<float> both(2 * a.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            both[2 * i] = a[i];
            both[2 * i + 1] = b.empty() ? 0 : b[i];
        }
        glTextureSubImage2D(texture.name(), 0, 0, row, GLsizei(a.size()), 1, GL_RG, GL_FLOAT, both.data());
    };
    upload(0, angles.column_a, angles.column_b);
    upload(1, angles.row_a, angles.row_b);
    return texture;
}

}  // namespace

MeshDepth::MeshDepth(const EngineOptions& options)
    : options_(options), cells_({{GL_COMPUTE_SHADER, "mesh_cells.glsl"}}),
      fans_({{GL_COMPUTE_SHADER, "mesh_fans.glsl"}}),
      draw_({{GL_VERTEX_SHADER, "mesh_vertex.glsl"}, {GL_FRAGMENT_SHADER, "mesh_fragment.glsl"}}, defines),
      forget_gaps_({{GL_COMPUTE_SHADER, "forget_gaps.glsl"}}), no_vertices_(make_vertex_array()) {}

void MeshDepth::size_for_source(const Camera& camera) {
    const Size size{width_of(camera), height_of(camera)};
    if (source_.width != 0 && same_camera(camera, camera_))
        return;
    if (std::max(size.width, size.height) > most_side)
        throw WorkError(expected_found("method mesh",
                                       "pictures of up to " + std::to_string(most_side) + " columns and rows",
                                       std::to_string(size.width) + "x" + std::to_string(size.height)));
    built_ = {};
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    closes_ = sphere != nullptr && sphere->range.closes();
    angles_ = uploaded_angles(camera);
    corners_ = make_texture({size.width + 2, size.height + 2}, GL_R8UI);
    const std::size_t cells = std::size_t(size.width + 1) * std::size_t(size.height + 1);
    lists_ = make_buffer(sizeof(ListsHead), GL_DYNAMIC_STORAGE_BIT);
    for (Buffer* list : {&quads_, &cuts_})
        *list = make_buffer(cells * sizeof(GLuint), 0);
    // A cell's border is no longer than its area, those of two a side that meet smaller ones taken together with them.
    fans_list_ = make_buffer(2 * cells * sizeof(GLuint), 0);
    large_ = make_buffer(cells / 4 * sizeof(GLuint) + sizeof(GLuint), 0);
    camera_ = camera;
    source_ = size;
}

void MeshDepth::size_for_eyes(Size size, int eyes) {
    if (size == eye_size_ && eyes == eyes_)
        return;
    depth_ = make_layered_texture(size, eyes, GL_R32F);
    depth_buffer_ = make_layered_texture(size, eyes, GL_DEPTH_COMPONENT32F);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    framebuffer_ = Framebuffer(name);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, depth_.name(), 0);
    glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth_buffer_.name(), 0);
    require_complete(framebuffer_);
    eye_size_ = size;
    eyes_ = eyes;
}

void MeshDepth::bind_lists() const {
    const std::array lists = {lists_.name(), quads_.name(), fans_list_.name(), cuts_.name(), large_.name()};
    for (GLuint i = 0; i < lists.size(); ++i)
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, lists[i]);
}

void MeshDepth::build(const Within& within) {
    const ListsHead nothing;
    const GLuint no_corner = 0;
    // A shader wrote what is there.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
    glNamedBufferSubData(lists_.name(), 0, sizeof nothing, &nothing);
    glClearTexImage(corners_.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &no_corner);
    glBindImageTexture(0, corners_.name(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R8UI);
    cells_.set("joins", glm::vec2(within.box_radius_m, within.tolerance));
    cells_.set("share", within.share);
    cells_.use();
    constexpr int side = LatticeBlock::side;
    const int columns = source_.width + (closes_ ? 0 : 1), rows = source_.height + 1;
    glDispatchCompute(GLuint((columns + side - 1) / side), GLuint((rows + side - 1) / side), 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    fans_.dispatch_indirect(lists_.name(), offsetof(ListsHead, large_groups));
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    built_ = within;
}

void MeshDepth::draw(const Within& within) {
    const auto instances = GLuint(eyes_);
    for (std::size_t list = 0; list < ListsHead{}.draws.size(); ++list)
        glNamedBufferSubData(lists_.name(), GLintptr(list * sizeof(Draw) + offsetof(Draw, instances)), sizeof instances,
                             &instances);
    const DrawingState state(GL_GEQUAL, DrawingState::Near::clamped);
    const float miss = 0, nothing = std::nanf("");
    glClearNamedFramebufferfv(framebuffer_.name(), GL_DEPTH, 0, &miss);
    glClearNamedFramebufferfv(framebuffer_.name(), GL_COLOR, 0, &nothing);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    glViewport(0, 0, eye_size_.width, eye_size_.height);
    glBindVertexArray(no_vertices_.name());
    draw_.set("eye_size", glm::vec2(eye_size_.width, eye_size_.height));
    draw_.set("joins", glm::vec2(within.box_radius_m, within.tolerance));
    draw_.use();
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, lists_.name());
    for (std::size_t list = 0; list < ListsHead{}.draws.size(); ++list) {
        draw_.set("list", int(list));
        glDrawArraysIndirect(GL_TRIANGLES, reinterpret_cast<const void*>(list * sizeof(Draw)));
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

void MeshDepth::find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) {
    assert(source.depth() != 0 && !eyes.empty() && eyes.size() <= std::size_t(most_eyes));
    size_for_source(view.camera);
    const PerspectiveCamera& camera = eyes.front().camera;
    size_for_eyes({camera.width, camera.height}, int(eyes.size()));
    double radius_m = view.box_radius_m;
    for (const EyeView& eye : eyes)
        radius_m = std::max(radius_m, glm::distance(view.pose.position_m, eye.pose.position_m));
    const double tolerance_rad = 4 * options_.error_budget_px * error_budget_rad(camera.focal_px());
    // Half of what the mesh may be off: cells that are fanned out to meet smaller ones leave their own triangles by as
    // much again.
    const Within within{float(radius_m), float(std::sin(tolerance_rad)),
                        0.5f * float(std::sin(options_.mesh_share * tolerance_rad))};
    eye_blocks_.set(view, eyes, options_.error_budget_px);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, eye_blocks_.name());
    glBindTextureUnit(1, source.depth());
    glBindTextureUnit(5, angles_.name());
    bind_lists();
    if (!(within == built_))
        build(within);
    draw(within);
}

void MeshDepth::forget_gaps(const EyeTargets& targets) const {
    assert(targets.size() == eye_size_ && targets.eyes() == eyes_);
    glBindTextureUnit(3, targets.origin());
    glBindImageTexture(0, depth_.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    forget_gaps_.dispatch(eye_size_, eyes_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
}

}  // namespace equistream::gl
