#include "depth_pass.h"

#include <equistream/text.h>

#include <client/gpu/drawing_state.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace equistream::gl {

ViewBlock view_block(const DepthViewpoint& view) {
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
    block.scale = {2 * focal / view.camera.width, -2 * focal / view.camera.height, 0, 0};
    block.size = {view.camera.width, view.camera.height, 0, 0};
    return block;
}

namespace {

/// Attributes of depth_vertex.glsl.
enum Attribute : GLuint { position, row_x, row_y, row_w, identity, uv, attribute_count };

constexpr std::array<Stage, 2> stages = {
    {{GL_VERTEX_SHADER, "depth_vertex.glsl"}, {GL_FRAGMENT_SHADER, "depth_fragment.glsl"}}};

/// A size of storage for so many texels: a view that follows a moving head rarely asks for another.
int whole_steps(int texels) {
    constexpr int step = 64;
    return (texels + step - 1) / step * step;
}

std::vector<std::string> masked_defines() {
    std::vector<std::string> all = DepthPass::geometry_defines();
    all.emplace_back("MASKED 1");
    return all;
}

}  // namespace

DepthPass::DepthPass(const SceneModel& model)
    : geometry_(model), culling_(geometry_), opaque_({stages[0], stages[1]}, geometry_defines()),
      masked_({stages[0], stages[1]}, masked_defines()),
      views_(make_buffer(max_views * sizeof(ViewBlock), GL_DYNAMIC_STORAGE_BIT)), vertices_(make_vertex_array()) {
    const GLuint name = vertices_.name();
    glVertexArrayElementBuffer(name, geometry_.indices());
    glVertexArrayVertexBuffer(name, 0, geometry_.positions(), 0, sizeof(glm::vec3));
    glVertexArrayVertexBuffer(name, 2, geometry_.uvs(), 0, sizeof(glm::vec2));
    glVertexArrayBindingDivisor(name, 1, 1);
    glVertexArrayAttribFormat(name, position, 3, GL_FLOAT, GL_FALSE, 0);
    for (const GLuint row : {row_x, row_y, row_w})
        glVertexArrayAttribFormat(name, row, 4, GL_FLOAT, GL_FALSE, GLuint(sizeof(glm::vec4)) * (row - row_x));
    glVertexArrayAttribIFormat(name, identity, 4, GL_UNSIGNED_INT, 3 * sizeof(glm::vec4));
    glVertexArrayAttribFormat(name, uv, 2, GL_FLOAT, GL_FALSE, 0);
    for (GLuint attribute = 0; attribute < (geometry_.has_masks() ? attribute_count : uv); ++attribute) {
        glVertexArrayAttribBinding(name, attribute, attribute == position ? 0u : attribute == uv ? 2u : 1u);
        glEnableVertexArrayAttrib(name, attribute);
    }
}

void DepthPass::size_for(std::span<const DepthViewpoint> views) {
    Size size = size_;
    for (const DepthViewpoint& view : views)
        size = {std::max(size.width, whole_steps(view.camera.width)),
                std::max(size.height, whole_steps(view.camera.height))};
    const int layers = std::max(layers_, int(views.size()));
    if (size == size_ && layers == layers_)
        return;
    Texture depth = make_layered_texture(size, layers, GL_DEPTH_COMPONENT32F);
    Texture triangles = make_layered_texture(size, layers, GL_R32UI);
    Framebuffer framebuffer = make_framebuffer(std::array{triangles.name()}, depth.name());
    culling_.size_for(size, layers);
    glVertexArrayVertexBuffer(vertices_.name(), 1, culling_.records(), 0, ClusterCulling::record_bytes);
    size_ = size;
    layers_ = layers;
    depth_ = std::move(depth);
    triangles_ = std::move(triangles);
    framebuffer_ = std::move(framebuffer);
}

void DepthPass::draw_found(int round) const {
    opaque_.use();
    culling_.draw(round, false);
    if (!geometry_.has_masks())
        return;
    geometry_.bind();
    masked_.use();
    culling_.draw(round, true);
}

void DepthPass::draw(std::span<const DepthViewpoint> views, Culling culling) {
    assert(!views.empty() && views.size() <= max_views);
    size_for(views);
    std::array<ViewBlock, max_views> blocks;
    std::ranges::transform(views, blocks.begin(), view_block);
    glNamedBufferSubData(views_.name(), 0, GLsizeiptr(views.size() * sizeof(ViewBlock)), blocks.data());
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, views_.name());

    const DrawingState state(GL_GREATER);
    constexpr float miss = 0;
    constexpr std::array<GLuint, 4> none{};
    glClearNamedFramebufferfv(framebuffer_.name(), GL_DEPTH, 0, &miss);
    glClearNamedFramebufferuiv(framebuffer_.name(), GL_COLOR, 0, none.data());
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    for (std::size_t i = 0; i < views.size(); ++i)
        glViewportIndexedf(GLuint(i), 0, 0, float(views[i].camera.width), float(views[i].camera.height));
    glBindVertexArray(vertices_.name());
    culling_.start(int(views.size()), culling);
    culling_.find(0);
    draw_found(0);
    if (culling == Culling::hidden) {
        culling_.find_rest(depth_);
        draw_found(1);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

std::vector<std::string> DepthPass::geometry_defines() {
    return {formatted("MAX_TRIANGLES %zuu", SceneGeometry::max_cluster_triangles),
            formatted("MAX_VIEWS %du", max_views), formatted("NEAR_PLANE_M %.9g", near_plane_m)};
}

}  // namespace equistream::gl
