#include "mesh_depth.h"

#include <client/warp/source_lattice.h>

#include <equistream/bound.h>
#include <equistream/error.h>

#include <client/gpu/drawing_state.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

/// As mesh_lists.glsl has them.
struct Refresh {
    GLuint draws;
    std::array<GLuint, 2> listed;
    std::array<std::array<GLuint, 3>, 2> groups;
};
struct Counts {
    GLuint points, indices;
    Refresh refresh;
    GLint forgotten;
};
struct Block {
    GLuint first_point, point_room, first_index, index_room, index_count, seen, cells_of, points_of;
};
constexpr int corner_words = LatticeBlock::side + 3;
struct Draw {
    GLuint index_count, instances, first_index, base_vertex, eye;
};
constexpr std::size_t point_bytes = 4 * sizeof(float);
/// Of a block of which every cell is drawn; those over a pole are drawn both ways.
constexpr std::uint64_t plain_points = (LatticeBlock::side + 1) * (LatticeBlock::side + 1),
                        plain_indices = 6 * LatticeBlock::side * (LatticeBlock::side + 1);

/// Of the depth buffer alone: what is nearer keeps its order no more, and its distance all the same.
const std::vector<std::string> defines = {"NEAR_PLANE_M 1e-3"};

/// By which what cells may be off by, and from how far, is rounded, so that they are not built anew at every step.
constexpr double step = 1.25;

/// At most what one buffer of a shader's may hold, of values of so many bytes.
GLuint within_storage(std::uint64_t count, std::size_t bytes) {
    return GLuint(std::min(count, std::uint64_t(max_storage_bytes()) / bytes));
}

/// Of more than is needed: the next source needs a little more or less.
GLuint with_reserve(GLuint needed, std::size_t bytes) {
    return std::max(needed, within_storage(std::uint64_t(needed) + needed / 2, bytes));
}

}  // namespace

MeshDepth::MeshDepth(const EngineOptions& options, bool plain)
    : EyeDepthFinder(options,
                     {.only_seen = !plain, .error_budget_px = options.budget_px_of(plain ? "mesh-plain" : "mesh")}),
      plain_(plain), begin_("mesh_begin.glsl"), wanted_("mesh_wanted.glsl"),
      cells_("mesh_cells.glsl", plain ? std::vector<std::string>{"PLAIN"} : std::vector<std::string>{}),
      points_pass_("mesh_points.glsl"), draws_pass_("mesh_draws.glsl"),
      draw_({{GL_VERTEX_SHADER, "mesh_vertex.glsl"}, {GL_FRAGMENT_SHADER, "mesh_fragment.glsl"}}, defines),
      vertices_(make_vertex_array()) {
    constexpr Counts nothing{};
    counts_ = make_buffer_of(std::span(&nothing, 1));
    constexpr GLbitfield mapped = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    needed_ = make_buffer(sizeof(Room), mapped | GL_CLIENT_STORAGE_BIT);
    needed_words_ = static_cast<const Room*>(glMapNamedBufferRange(needed_.name(), 0, sizeof(Room), mapped));
    if (needed_words_ == nullptr)
        throw WorkError("OpenGL: the driver cannot keep a buffer mapped");
    std::array<GLuint, max_eyes> numbers{};
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

void MeshDepth::size_for_source(const Camera& camera) {
    const Size size{width_of(camera), height_of(camera)};
    if (std::max(size.width, size.height) > max_side)
        throw WorkError(expected_found(plain_ ? "method mesh-plain" : "method mesh",
                                       "pictures of up to " + std::to_string(max_side) + " columns and rows",
                                       std::to_string(size.width) + "x" + std::to_string(size.height)));
    // What failed half-way is begun anew.
    if (lattice_.set(camera) && is_sized_)
        return;
    knows_source_ = has_room_ = is_sized_ = false;
    source_blocks_.size_for(camera);
    cell_map_ = make_texture({size.width + 1, size.height + 1}, GL_R8UI);
    const auto block_count = std::size_t(source_blocks_.count());
    blocks_ = make_buffer(block_count * sizeof(Block), 0);
    lists_ = make_buffer(2 * block_count * sizeof(GLuint), 0);
    corners_ = make_buffer(block_count * corner_words * sizeof(GLuint), 0);
    draws_ = make_buffer(block_count * max_eyes * sizeof(Draw), 0);
    forget_blocks();
    // Enough for walls and furniture, and leaves and railings make room for more; or for all that there can be.
    const auto cells = std::uint64_t(size.width) * std::uint64_t(size.height);
    const std::uint64_t points = plain_ ? block_count * plain_points : cells / 2,
                        indices = plain_ ? block_count * plain_indices : 3 * cells;
    make_room({std::max(room_.points, within_storage(points, point_bytes)),
               std::max(room_.indices, within_storage(indices, sizeof(GLuint)))});
    is_sized_ = true;
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
    if (size_for(size, eyes) && framebuffer_)
        return;
    framebuffer_ = {};  // what fails half-way is begun anew
    depth_buffer_ = make_layered_texture(size, eyes, GL_DEPTH_COMPONENT32F);
    framebuffer_ = make_framebuffer(std::array{depth().texture}, depth_buffer_.name());
}

/// From the next build on there are none, and all room is free.
void MeshDepth::forget_blocks() {
    const GLuint nothing = 0;
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glClearNamedBufferData(blocks_.name(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &nothing);
    ++forget_number_;
    glDeleteSync(counted_);
    counted_ = nullptr;
}

void MeshDepth::run_over_blocks(const Program& program) const {
    program.set("eye_count", eyes_);
    program.use();
    glDispatchCompute(GLuint((source_blocks_.count() + 63) / 64), 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

/// What eyes see and is not there yet; then what of it is drawn.
void MeshDepth::build() {
    if (!knows_source_)
        source_blocks_.find();
    knows_source_ = true;
    for (const Program* const program : {&wanted_, &cells_, &points_pass_, &draws_pass_})
        source_blocks_.bind(*program, 1);
    const std::array buffers = {blocks_.name(), lists_.name(), corners_.name(), points_.name(), indices_.name()};
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, counts_.name());
    glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 2, GLsizei(buffers.size()), buffers.data());
    glBindImageTexture(0, cell_map_.name(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R8UI);
    begin_.set("forget_number", forget_number_);
    begin_.use();
    glDispatchCompute(1, 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    wanted_.set("eye_size", glm::vec2(size_.width, size_.height));
    run_over_blocks(wanted_);
    const glm::vec2 joins(within_.box_radius_m, std::sin(within_.tolerance_rad));
    cells_.set("joins", joins);
    // Half of what the mesh may be off: cells that are fanned out to meet smaller ones leave their own triangles by as
    // much again.
    cells_.set("share", 0.5f * float(std::sin(options_.mesh_share * within_.tolerance_rad)));
    points_pass_.set("joins", joins);
    constexpr std::size_t groups = offsetof(Counts, refresh) + offsetof(Refresh, groups);
    cells_.dispatch_indirect(counts_.name(), groups);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
    points_pass_.dispatch_indirect(counts_.name(), groups + sizeof Refresh::groups[0]);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_ELEMENT_ARRAY_BARRIER_BIT |
                    GL_BUFFER_UPDATE_BARRIER_BIT);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, draws_.name());
    run_over_blocks(draws_pass_);
    if (counted_ != nullptr)
        return;  // what is asked for meanwhile the next one tells
    glCopyNamedBufferSubData(counts_.name(), needed_.name(), 0, 0, sizeof(Room));
    counted_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
}

/// If it is known by now what was needed, or by waiting.
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
    make_room({with_reserve(needed.points, point_bytes), with_reserve(needed.indices, sizeof(GLuint))});
    forget_blocks();
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
        forget_blocks();
    }
    make_room_if_needed(false);
    build();
    if (has_room_)
        return;
    make_room_if_needed(true);
    build();
}

void MeshDepth::draw() {
    const DrawingState state(GL_GEQUAL, DrawingState::Near::clamped);
    constexpr float miss = 0;
    constexpr std::array nothing = {std::numeric_limits<float>::quiet_NaN(), 0.0f, 0.0f, 0.0f};
    glClearNamedFramebufferfv(framebuffer_.name(), GL_DEPTH, 0, &miss);
    glClearNamedFramebufferfv(framebuffer_.name(), GL_COLOR, 0, nothing.data());
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    glViewport(0, 0, size_.width, size_.height);
    glBindVertexArray(vertices_.name());
    draw_.set("eye_size", glm::vec2(size_.width, size_.height));
    draw_.use();
    // What stretches from edges to what lies behind is seen from both sides.
    if (!plain_)
        glEnable(GL_CULL_FACE);
    glCullFace(GL_BACK);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, draws_.name());
    glBindBuffer(GL_PARAMETER_BUFFER_ARB, counts_.name());
    glMultiDrawElementsIndirectCountARB(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr,
                                        offsetof(Counts, refresh) + offsetof(Refresh, draws),
                                        source_blocks_.count() * eyes_, sizeof(Draw));
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
    build_within({radius_m, error_budget_rad(camera.focal_px(), traits_.error_budget_px)});
    draw();
}

std::unique_ptr<EyeDepthFinder> make_mesh_depth(const EngineOptions& options) {
    return std::make_unique<MeshDepth>(options);
}

std::unique_ptr<EyeDepthFinder> make_plain_mesh_depth(const EngineOptions& options) {
    return std::make_unique<MeshDepth>(options, true);
}

}  // namespace equistream::gl
