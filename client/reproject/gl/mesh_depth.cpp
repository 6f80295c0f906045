#include "mesh_depth.h"

#include "../source_lattice.h"

#include <equistream/bound.h>
#include <equistream/error.h>

#include <gl/drawing_state.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

/// As mesh_lists.glsl has them.
struct Counts {
    GLuint points = 0, indices = 0, draws = 0;
};
struct Block {
    std::array<float, 4> cone;
    std::array<float, 2> inverses;
    GLuint first_index, index_count;
};
struct Draw {
    GLuint index_count, instances, first_index, base_vertex, eye;
};
constexpr std::size_t point_bytes = 4 * sizeof(float);

/// Of the depth buffer alone: what is nearer keeps its order no more, and its distance all the same.
const std::vector<std::string> defines = {
    "NEAR_PLANE_M 1e-3", "MESH_LEVELS " + std::to_string(std::countr_zero(unsigned(LatticeBlock::side)))};

/// By which what cells may be off by, and from how far, is rounded, so that they are not built anew at every step.
constexpr double step = 1.25;

/// Of more than is needed: the next source needs a little more or less.
GLuint with_reserve(GLuint needed) {
    return needed + needed / 2;
}

}  // namespace

MeshDepth::MeshDepth(const EngineOptions& options)
    : EyeDepthFinder(options), cells_({{GL_COMPUTE_SHADER, "mesh_cells.glsl"}}, defines),
      points_pass_({{GL_COMPUTE_SHADER, "mesh_points.glsl"}}, defines),
      cull_({{GL_COMPUTE_SHADER, "mesh_cull.glsl"}}, defines),
      draw_({{GL_VERTEX_SHADER, "mesh_vertex.glsl"}, {GL_FRAGMENT_SHADER, "mesh_fragment.glsl"}}, defines),
      vertices_(make_vertex_array()), counts_(make_buffer(sizeof(Counts), GL_DYNAMIC_STORAGE_BIT)) {
    constexpr GLbitfield mapped = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    needed_ = make_buffer(sizeof(Room), mapped | GL_CLIENT_STORAGE_BIT);
    needed_words_ = static_cast<const Room*>(glMapNamedBufferRange(needed_.name(), 0, sizeof(Room), mapped));
    std::array<GLuint, most_eyes> numbers{};
    std::iota(numbers.begin(), numbers.end(), 0U);
    eye_numbers_ = make_buffer_of(std::span<const GLuint>(numbers));
    const GLuint name = vertices_.name();
    glVertexArrayAttribFormat(name, 0, 4, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribIFormat(name, 1, 1, GL_UNSIGNED_INT, 0);
    glVertexArrayVertexBuffer(name, 1, eye_numbers_.name(), 0, sizeof(GLuint));
    glVertexArrayBindingDivisor(name, 1, 1);
    for (const GLuint attribute : {0U, 1U}) {
        glVertexArrayAttribBinding(name, attribute, attribute);
        glEnableVertexArrayAttrib(name, attribute);
    }
}

MeshDepth::~MeshDepth() {
    glDeleteSync(counted_);
}

Size MeshDepth::blocks() const {
    constexpr int side = LatticeBlock::side;
    const int columns = lattice_.size().width + (closes_ ? 0 : 1), rows = lattice_.size().height + 1;
    return {(columns + side - 1) / side, (rows + side - 1) / side};
}

void MeshDepth::size_for_source(const Camera& camera) {
    if (lattice_.set(camera))
        return;
    const Size size = lattice_.size();
    if (std::max(size.width, size.height) > most_side)
        throw WorkError(expected_found("method mesh",
                                       "pictures of up to " + std::to_string(most_side) + " columns and rows",
                                       std::to_string(size.width) + "x" + std::to_string(size.height)));
    is_built_ = has_room_ = false;
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    closes_ = sphere != nullptr && sphere->range.closes();
    corners_ = make_texture({size.width + 2, size.height + 2}, GL_R8UI);
    cell_map_ = make_texture({size.width + 1, size.height + 1}, GL_R8UI);
    const auto block_count = std::size_t(blocks().width) * std::size_t(blocks().height);
    blocks_ = make_buffer(block_count * sizeof(Block), 0);
    draws_ = make_buffer(block_count * most_eyes * sizeof(Draw), 0);
    // Enough for walls and furniture; leaves and railings make room for more.
    const auto cells = GLuint(size.width) * GLuint(size.height);
    make_room({std::max(room_.points, cells / 2), std::max(room_.indices, 3 * cells)});
}

void MeshDepth::make_room(Room room) {
    if (room.points > room_.points) {
        points_ = make_buffer(room.points * point_bytes, 0);
        glVertexArrayVertexBuffer(vertices_.name(), 0, points_.name(), 0, point_bytes);
        room_.points = room.points;
    }
    if (room.indices > room_.indices) {
        indices_ = make_buffer(room.indices * sizeof(GLuint), 0);
        glVertexArrayElementBuffer(vertices_.name(), indices_.name());
        room_.indices = room.indices;
    }
}

void MeshDepth::size_for_eyes(Size size, int eyes) {
    if (layers_.size_for(size, eyes))
        return;
    depth_buffer_ = make_layered_texture(size, eyes, GL_DEPTH_COMPONENT32F);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    framebuffer_ = Framebuffer(name);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, layers_.depth().texture, 0);
    glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth_buffer_.name(), 0);
    require_complete(framebuffer_);
}

void MeshDepth::build() {
    const Counts nothing;
    const GLuint no_corner = 0;
    // Shaders wrote and read what is there.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
    glNamedBufferSubData(counts_.name(), 0, sizeof nothing, &nothing);
    glClearTexImage(corners_.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &no_corner);
    glBindImageTexture(0, cell_map_.name(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R8UI);
    glBindImageTexture(1, corners_.name(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R8UI);
    const std::array buffers = {counts_.name(), blocks_.name(), points_.name(), indices_.name()};
    glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, GLsizei(buffers.size()), buffers.data());
    const Size groups = blocks();
    const glm::vec2 joins(within_.box_radius_m, std::sin(within_.tolerance_rad));
    cells_.set("joins", joins);
    // Half of what the mesh may be off: cells that are fanned out to meet smaller ones leave their own triangles by as
    // much again.
    cells_.set("share", 0.5f * float(std::sin(options_.mesh_share * within_.tolerance_rad)));
    cells_.use();
    glDispatchCompute(GLuint(groups.width), GLuint(groups.height), 1);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    points_pass_.set("joins", joins);
    points_pass_.set("block_columns", groups.width);
    points_pass_.use();
    glDispatchCompute(GLuint(groups.width), GLuint(groups.height), 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_ELEMENT_ARRAY_BARRIER_BIT |
                    GL_BUFFER_UPDATE_BARRIER_BIT);
    glCopyNamedBufferSubData(counts_.name(), needed_.name(), 0, 0, sizeof(Room));
    glDeleteSync(counted_);
    counted_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    is_built_ = true;
}

/// If it is known by now what the last build needed, or by waiting.
void MeshDepth::make_room_if_needed(bool wait) {
    if (counted_ == nullptr)
        return;
    const GLenum state = glClientWaitSync(counted_, GL_SYNC_FLUSH_COMMANDS_BIT, wait ? GL_TIMEOUT_IGNORED : 0);
    if (state != GL_ALREADY_SIGNALED && state != GL_CONDITION_SATISFIED)
        return;
    glDeleteSync(counted_);
    counted_ = nullptr;
    has_room_ = true;
    const Room needed = *needed_words_;
    if (needed.points <= room_.points && needed.indices <= room_.indices)
        return;
    make_room({with_reserve(needed.points), with_reserve(needed.indices)});
    is_built_ = false;
}

void MeshDepth::build_within(const Within& wanted) {
    const auto serves = [](double built, double needed) { return built >= needed / step && built <= needed * step; };
    const bool wide_enough = within_.box_radius_m >= wanted.box_radius_m;
    const bool fine_enough = within_.tolerance_rad <= wanted.tolerance_rad;
    if (!(wide_enough && serves(within_.box_radius_m, wanted.box_radius_m)) ||
        !(fine_enough && serves(within_.tolerance_rad, wanted.tolerance_rad))) {
        // Those of the first frame as they are; later ones in the middle of what they serve.
        const double room = within_.tolerance_rad == 0 ? 1 : std::sqrt(step);
        within_ = {wanted.box_radius_m * room, wanted.tolerance_rad / room};
        is_built_ = false;
    }
    make_room_if_needed(false);
    if (is_built_)
        return;
    build();
    if (has_room_)
        return;
    make_room_if_needed(true);
    if (!is_built_)
        build();
}

void MeshDepth::cull() {
    constexpr GLuint none = 0;
    // The last draws were written by a shader.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glNamedBufferSubData(counts_.name(), offsetof(Counts, draws), sizeof none, &none);
    const std::array buffers = {counts_.name(), blocks_.name(), draws_.name()};
    glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, GLsizei(buffers.size()), buffers.data());
    const int count = blocks().width * blocks().height;
    cull_.set("block_count", count);
    cull_.set("eye_count", layers_.eyes());
    cull_.set("eye_size", glm::vec2(layers_.size().width, layers_.size().height));
    cull_.use();
    glDispatchCompute(GLuint((count + 63) / 64), 1, 1);
    glMemoryBarrier(GL_COMMAND_BARRIER_BIT);
}

void MeshDepth::draw() {
    const DrawingState state(GL_GEQUAL, DrawingState::Near::clamped);
    const float miss = 0, nothing = std::nanf("");
    glClearNamedFramebufferfv(framebuffer_.name(), GL_DEPTH, 0, &miss);
    glClearNamedFramebufferfv(framebuffer_.name(), GL_COLOR, 0, &nothing);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    glViewport(0, 0, layers_.size().width, layers_.size().height);
    glBindVertexArray(vertices_.name());
    draw_.set("eye_size", glm::vec2(layers_.size().width, layers_.size().height));
    draw_.use();
    glEnable(GL_CULL_FACE);
    glCullFace(GL_BACK);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, draws_.name());
    glBindBuffer(GL_PARAMETER_BUFFER_ARB, counts_.name());
    glMultiDrawElementsIndirectCountARB(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr, offsetof(Counts, draws),
                                        blocks().width * blocks().height * layers_.eyes(), sizeof(Draw));
    glDisable(GL_CULL_FACE);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void MeshDepth::find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) {
    size_for_source(view.camera);
    const PerspectiveCamera& camera = eyes.front().camera;
    size_for_eyes({camera.width, camera.height}, int(eyes.size()));
    double radius_m = view.box_radius_m;
    for (const EyeView& eye : eyes)
        radius_m = std::max(radius_m, glm::distance(view.pose.position_m, eye.pose.position_m));
    bind(view, source, eyes);
    build_within({radius_m, 4 * options_.error_budget_px * error_budget_rad(camera.focal_px())});
    cull();
    draw();
}

}  // namespace equistream::gl
