#include "depth_pass.h"

#include <equistream/formatted.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>
#include <utility>

namespace equistream::gl {

namespace {

/// As the shaders have them.
struct Item {
    glm::vec4 ball;
    std::uint32_t first_index, index_count, instance, masked;
};
struct Command {
    std::uint32_t count, instances, first_index, base_vertex, base_instance;
};
struct Counts {
    std::uint32_t opaque, masked, triangles;
};
struct Mask {
    std::uint32_t first_bit, width, height, wrap;
};
struct ViewBlock {
    glm::mat4 view_from_world;
    glm::vec4 planes[4];
    glm::vec4 scale;
};

constexpr GLuint group_items = 64;

std::vector<std::string> masked_defines() {
    std::vector<std::string> all = DepthPass::geometry_defines();
    all.emplace_back("MASKED 1");
    return all;
}

ViewBlock block_of(const DepthViewpoint& view) {
    ViewBlock block;
    const glm::dmat4 turn = glm::mat4_cast(glm::conjugate(view.pose.orientation));
    block.view_from_world = glm::mat4(glm::translate(turn, -view.pose.position_m));
    const double focal = view.camera.focal_px();
    const double edge_x = view.camera.width / (2 * focal), edge_y = view.camera.height / (2 * focal);
    const auto side = [](double x, double y, double edge) {
        return glm::vec4(glm::normalize(glm::dvec3(x, y, -edge)), 0);
    };
    block.planes[0] = side(1, 0, edge_x);
    block.planes[1] = side(-1, 0, edge_x);
    block.planes[2] = side(0, 1, edge_y);
    block.planes[3] = side(0, -1, edge_y);
    // Row 0 is the first: y runs down.
    block.scale = {2 * focal / view.camera.width, -2 * focal / view.camera.height, near_plane_m, 0};
    return block;
}

/// All state that drawing depth relies on; clip control, the depth test and its function are as before when it goes.
class DrawingState {
public:
    DrawingState() : has_depth_test_(glIsEnabled(GL_DEPTH_TEST)) {
        glGetIntegerv(GL_CLIP_ORIGIN, &clip_origin_);
        glGetIntegerv(GL_CLIP_DEPTH_MODE, &clip_depth_);
        glGetIntegerv(GL_DEPTH_FUNC, &depth_function_);
        for (const GLenum off : {GL_SCISSOR_TEST, GL_CULL_FACE, GL_BLEND, GL_COLOR_LOGIC_OP, GL_DEPTH_CLAMP,
                                 GL_RASTERIZER_DISCARD, GL_POLYGON_OFFSET_FILL, GL_PRIMITIVE_RESTART})
            glDisable(off);
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(GL_GREATER);
        glDepthMask(GL_TRUE);
        glDepthRangef(0, 1);
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
        glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    }
    ~DrawingState() {
        glClipControl(GLenum(clip_origin_), GLenum(clip_depth_));
        glDepthFunc(GLenum(depth_function_));
        if (has_depth_test_ == GL_FALSE)
            glDisable(GL_DEPTH_TEST);
    }
    DrawingState(const DrawingState&) = delete;
    DrawingState& operator=(const DrawingState&) = delete;

private:
    GLboolean has_depth_test_;
    GLint clip_origin_ = 0, clip_depth_ = 0, depth_function_ = 0;
};

}  // namespace

DepthPass::DepthPass(const SceneModel& model)
    : cull_({{GL_COMPUTE_SHADER, "cull.glsl"}}, geometry_defines()),
      opaque_({{GL_VERTEX_SHADER, "depth_vertex.glsl"}, {GL_FRAGMENT_SHADER, "depth_fragment.glsl"}},
              geometry_defines()),
      masked_({{GL_VERTEX_SHADER, "depth_vertex.glsl"}, {GL_FRAGMENT_SHADER, "depth_fragment.glsl"}}, masked_defines()),
      triangle_count_(model.triangle_count()), instance_count_(std::uint32_t(model.instances.size())),
      views_(make_buffer(most_views * sizeof(ViewBlock), GL_DYNAMIC_STORAGE_BIT)) {
    const ClusteredMeshes meshes = cluster_meshes(model);
    std::vector<Item> items;
    for (std::uint32_t i = 0; i < instance_count_; ++i) {
        const std::uint32_t mesh = model.instances[i].mesh;
        const bool masked = model.mask_of(model.meshes[mesh]) != no_index;
        has_masks_ = has_masks_ || masked;
        const ClusteredMeshes::Range range = meshes.of_mesh[mesh];
        for (std::uint32_t c = range.first; c < range.first + range.count; ++c) {
            const Cluster& cluster = meshes.clusters[c];
            items.push_back(
                {glm::vec4(cluster.centre, cluster.radius), cluster.first_index, cluster.index_count, i, masked});
        }
    }
    item_count_ = std::uint32_t(items.size());
    items_ = make_buffer_of(std::span<const Item>(items));
    opaque_commands_ = make_buffer(items.size() * most_views * sizeof(Command), 0);
    masked_commands_ = make_buffer(has_masks_ ? items.size() * most_views * sizeof(Command) : 0, 0);
    counts_ = make_buffer(sizeof(Counts), GL_DYNAMIC_STORAGE_BIT);
    transforms_ = make_buffer(instance_count_ * sizeof(glm::mat4), GL_DYNAMIC_STORAGE_BIT);
    growth_ = make_buffer(instance_count_ * sizeof(float), GL_DYNAMIC_STORAGE_BIT);
    std::vector<glm::mat4> transforms;
    for (const Instance& instance : model.instances)
        transforms.push_back(instance.world_from_object);
    set_transforms(transforms);
    upload_masks(model);

    positions_ = make_buffer_of(std::span<const glm::vec3>(meshes.positions));
    uvs_ = make_buffer_of(std::span<const glm::vec2>(meshes.uvs));
    indices_ = make_buffer_of(std::span<const std::uint32_t>(meshes.indices));
    std::vector<std::uint32_t> identities(items.size() * most_views);
    std::iota(identities.begin(), identities.end(), 0u);
    identities_ = make_buffer_of(std::span<const std::uint32_t>(identities));
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    vertices_ = VertexArray(name);
    glVertexArrayElementBuffer(name, indices_.name());
    glVertexArrayVertexBuffer(name, 0, positions_.name(), 0, sizeof(glm::vec3));
    glVertexArrayAttribFormat(name, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayVertexBuffer(name, 1, identities_.name(), 0, sizeof(std::uint32_t));
    glVertexArrayAttribIFormat(name, 1, 1, GL_UNSIGNED_INT, 0);
    glVertexArrayBindingDivisor(name, 1, 1);
    glVertexArrayVertexBuffer(name, 2, uvs_.name(), 0, sizeof(glm::vec2));
    glVertexArrayAttribFormat(name, 2, 2, GL_FLOAT, GL_FALSE, 0);
    for (GLuint attribute = 0; attribute < (has_masks_ ? 3u : 2u); ++attribute) {
        glVertexArrayAttribBinding(name, attribute, attribute);
        glEnableVertexArrayAttrib(name, attribute);
    }
}

void DepthPass::upload_masks(const SceneModel& model) {
    std::vector<Mask> masks;
    std::vector<std::uint32_t> bits;
    std::uint32_t bit = 0;
    for (const AlphaMask& mask : model.alpha_masks) {
        masks.push_back({bit, std::uint32_t(mask.width), std::uint32_t(mask.height),
                         std::uint32_t(mask.wrap_u) + 4 * std::uint32_t(mask.wrap_v)});
        bits.resize((std::size_t(bit) + mask.opaque.size() + 31) / 32, 0);
        for (std::size_t i = 0; i < mask.opaque.size(); ++i)
            bits[(bit + i) / 32] |= std::uint32_t(mask.opaque[i] != 0) << ((bit + i) % 32);
        bit += std::uint32_t((mask.opaque.size() + 31) / 32 * 32);
    }
    std::vector<std::uint32_t> of_instance;
    for (const Instance& instance : model.instances) {
        const std::uint32_t mask = model.mask_of(model.meshes[instance.mesh]);
        of_instance.push_back(mask == no_index ? 0 : mask);
    }
    masks_ = make_buffer_of(std::span<const Mask>(masks));
    mask_bits_ = make_buffer_of(std::span<const std::uint32_t>(bits));
    instance_masks_ = make_buffer_of(std::span<const std::uint32_t>(of_instance));
}

void DepthPass::set_transforms(std::span<const glm::mat4> world_from_object) {
    assert(world_from_object.size() == instance_count_);
    std::vector<float> growth(world_from_object.size());
    std::ranges::transform(world_from_object, growth.begin(), length_growth);
    glNamedBufferSubData(transforms_.name(), 0, GLsizeiptr(world_from_object.size_bytes()), world_from_object.data());
    glNamedBufferSubData(growth_.name(), 0, GLsizeiptr(growth.size() * sizeof(float)), growth.data());
}

void DepthPass::size_for(std::span<const DepthViewpoint> views) {
    Size size = size_;
    for (const DepthViewpoint& view : views)
        size = {std::max(size.width, view.camera.width), std::max(size.height, view.camera.height)};
    const int layers = std::max(layers_, int(views.size()));
    if (size == size_ && layers == layers_)
        return;
    Texture depth = make_layered_texture(size, layers, GL_DEPTH_COMPONENT32F);
    Texture triangles = make_layered_texture(size, layers, GL_R32UI);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    Framebuffer framebuffer(name);
    glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth.name(), 0);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, triangles.name(), 0);
    require_complete(framebuffer);
    size_ = size;
    layers_ = layers;
    depth_ = std::move(depth);
    triangles_ = std::move(triangles);
    framebuffer_ = std::move(framebuffer);
}

void DepthPass::cull(std::size_t views) {
    constexpr Counts none{};
    // The last cull's counts were written by a shader.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glNamedBufferSubData(counts_.name(), 0, sizeof none, &none);
    const std::array buffers = {items_.name(),           transforms_.name(), opaque_commands_.name(),
                                masked_commands_.name(), counts_.name(),     growth_.name()};
    glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, GLsizei(buffers.size()), buffers.data());
    cull_.set("item_count", int(item_count_));
    cull_.set("view_count", int(views));
    cull_.use();
    glDispatchCompute((item_count_ + group_items - 1) / group_items, 1, 1);
    glMemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

void DepthPass::draw_list(const Program& program, const Buffer& commands, GLintptr count_offset) const {
    program.use();
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands.name());
    glBindBuffer(GL_PARAMETER_BUFFER_ARB, counts_.name());
    glMultiDrawElementsIndirectCountARB(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr, count_offset,
                                        GLsizei(item_count_ * most_views), sizeof(Command));
}

void DepthPass::draw(std::span<const DepthViewpoint> views) {
    assert(!views.empty() && views.size() <= most_views);
    size_for(views);
    std::array<ViewBlock, most_views> blocks;
    std::ranges::transform(views, blocks.begin(), block_of);
    glNamedBufferSubData(views_.name(), 0, GLsizeiptr(views.size() * sizeof(ViewBlock)), blocks.data());
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, views_.name());
    cull(views.size());

    const DrawingState state;
    constexpr float miss = 0;
    constexpr std::array<GLuint, 4> none{};
    glClearNamedFramebufferfv(framebuffer_.name(), GL_DEPTH, 0, &miss);
    glClearNamedFramebufferuiv(framebuffer_.name(), GL_COLOR, 0, none.data());
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    for (std::size_t i = 0; i < views.size(); ++i)
        glViewportIndexedf(GLuint(i), 0, 0, float(views[i].camera.width), float(views[i].camera.height));
    glBindVertexArray(vertices_.name());
    draw_list(opaque_, opaque_commands_, offsetof(Counts, opaque));
    if (has_masks_) {
        bind_geometry();
        draw_list(masked_, masked_commands_, offsetof(Counts, masked));
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void DepthPass::bind_geometry() const {
    const std::array buffers = {items_.name(),   transforms_.name(),     positions_.name(), uvs_.name(),
                                indices_.name(), instance_masks_.name(), masks_.name(),     mask_bits_.name()};
    glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, GLsizei(buffers.size()), buffers.data());
}

std::vector<std::string> DepthPass::geometry_defines() {
    return {formatted("MOST_VIEWS %du", most_views), formatted("MOST_TRIANGLES %zuu", most_cluster_triangles)};
}

DrawnFigures DepthPass::drawn() const {
    Counts counts{};
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(counts_.name(), 0, sizeof counts, &counts);
    return {counts.opaque + counts.masked, counts.triangles};
}

}  // namespace equistream::gl
