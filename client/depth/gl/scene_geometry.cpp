#include "scene_geometry.h"

#include "clusters.h"

#include <equistream/formatted.h>

#include <algorithm>
#include <array>
#include <cassert>

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

std::vector<std::string> SceneGeometry::defines() {
    return {formatted("MAX_TRIANGLES %zuu", max_cluster_triangles)};
}

}  // namespace equistream::gl
