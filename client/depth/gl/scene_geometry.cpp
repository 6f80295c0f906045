#include "scene_geometry.h"

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <span>

namespace equistream::gl {

namespace {

/// As the shaders have them.
struct Item {
    glm::vec4 ball;
    std::uint32_t first_index, index_count, instance, masked;
};
struct Mask {
    std::uint32_t first_bit, width, height, wrap;
};

// A scene's triangles in clusters that lie close together, so that what a view does not see need not be drawn.

constexpr std::size_t max_cluster_triangles = SceneGeometry::max_cluster_triangles;

/// Triangles [first_index, first_index + index_count) of ClusteredMeshes::indices, within a ball in the mesh's axes.
struct Cluster {
    std::uint32_t first_index = 0, index_count = 0;
    glm::vec3 centre{0};
    float radius = 0;
};

/// All meshes of a model, one after the other; a mesh without triangles has no cluster.
struct ClusteredMeshes {
    struct Range {
        std::uint32_t first = 0, count = 0;
    };
    std::vector<glm::vec3> positions;
    std::vector<glm::vec2> uvs;  ///< empty unless a mesh is cut by a mask; zeros for those that are not
    std::vector<std::uint32_t> indices;
    std::vector<Cluster> clusters;
    std::vector<Range> of_mesh;  ///< its clusters
};

/// Those of one mesh, sorted so that neighbours in the list are neighbours in space.
void append_mesh(const SceneModel& model, const Mesh& mesh, ClusteredMeshes& all) {
    const auto first_vertex = std::uint32_t(all.positions.size());
    std::vector<std::uint32_t> sorted(mesh.triangles.size() * 3);
    meshopt_spatialSortTriangles(sorted.data(), &mesh.triangles[0].x, sorted.size(), &mesh.positions[0].x,
                                 mesh.positions.size(), sizeof(glm::vec3));
    for (std::size_t at = 0; at < sorted.size(); at += 3 * max_cluster_triangles) {
        const std::span<const std::uint32_t> part =
            std::span(sorted).subspan(at, std::min(3 * max_cluster_triangles, sorted.size() - at));
        const meshopt_Bounds bounds = meshopt_computeClusterBounds(part.data(), part.size(), &mesh.positions[0].x,
                                                                   mesh.positions.size(), sizeof(glm::vec3));
        all.clusters.push_back({std::uint32_t(all.indices.size()),
                                std::uint32_t(part.size()),
                                {bounds.center[0], bounds.center[1], bounds.center[2]},
                                bounds.radius});
        for (const std::uint32_t index : part)
            all.indices.push_back(first_vertex + index);
    }
    all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
    if (model.mask_of(mesh) == no_index)
        return;
    all.uvs.resize(first_vertex);
    all.uvs.insert(all.uvs.end(), mesh.uvs.begin(), mesh.uvs.end());
}

ClusteredMeshes cluster_meshes(const SceneModel& model) {
    ClusteredMeshes all;
    for (const Mesh& mesh : model.meshes) {
        const auto first = std::uint32_t(all.clusters.size());
        if (!mesh.triangles.empty())
            append_mesh(model, mesh, all);
        all.of_mesh.push_back({first, std::uint32_t(all.clusters.size()) - first});
    }
    if (!all.uvs.empty())
        all.uvs.resize(all.positions.size());
    return all;
}

}  // namespace

SceneGeometry::SceneGeometry(const SceneModel& model)
    : triangle_count_(model.triangle_count()), instance_count_(std::uint32_t(model.instances.size())) {
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
}

void SceneGeometry::upload_masks(const SceneModel& model) {
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

void SceneGeometry::set_transforms(std::span<const glm::mat4> world_from_object) {
    assert(world_from_object.size() == instance_count_);
    lengths_growth_.resize(world_from_object.size());
    std::ranges::transform(world_from_object, lengths_growth_.begin(), length_growth);
    glNamedBufferSubData(transforms_.name(), 0, GLsizeiptr(world_from_object.size_bytes()), world_from_object.data());
    glNamedBufferSubData(growth_.name(), 0, GLsizeiptr(lengths_growth_.size() * sizeof(float)), lengths_growth_.data());
}

void SceneGeometry::bind() const {
    const std::array buffers = {items_.name(),   transforms_.name(),     positions_.name(), uvs_.name(),
                                indices_.name(), instance_masks_.name(), masks_.name(),     mask_bits_.name()};
    glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, GLsizei(buffers.size()), buffers.data());
}

namespace {

/// Of a symmetric matrix, in closed form: it is q + p B where B has trace 0 and 6 for its squares' sum, so that its
/// eigenvalues are 2 cos(phi), 3 phi the arc cosine of half its determinant.
double max_eigenvalue(const glm::dmat3& a) {
    const double q = (a[0][0] + a[1][1] + a[2][2]) / 3;
    const glm::dmat3 rest = a - glm::dmat3(q);
    const double p =
        std::sqrt((glm::dot(rest[0], rest[0]) + glm::dot(rest[1], rest[1]) + glm::dot(rest[2], rest[2])) / 6);
    if (!(p > 0))
        return q;
    const double half = std::clamp(glm::determinant(rest * (1 / p)) / 2, -1.0, 1.0);
    return q + 2 * p * std::cos(std::acos(half) / 3);
}

}  // namespace

float length_growth(const glm::mat4& transform) {
    constexpr double above_rounding = 1 + 1e-6;
    const glm::dmat3 m(transform);
    return float(above_rounding * std::sqrt(max_eigenvalue(glm::transpose(m) * m)));
}

}  // namespace equistream::gl
