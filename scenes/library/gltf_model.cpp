#include "gltf_document.h"

#include <equistream/error.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace equistream {

namespace {

/// Accessors may be shared and meshes placed many times, so a small file can ask for a great deal: these bound it.
constexpr std::size_t element_limit = std::size_t{1} << 28;  ///< vertices, or indices, of all meshes together
constexpr std::size_t instance_limit = std::size_t{1} << 24;

using Indices = std::vector<std::uint32_t>;

std::vector<glm::uvec3> triangles_from_list(const Indices& indices, const std::string& where) {
    if (indices.size() % 3 != 0)
        throw InputError(expected_found(where, "a multiple of 3 indices", std::to_string(indices.size())));
    std::vector<glm::uvec3> triangles(indices.size() / 3);
    for (std::size_t i = 0; i < triangles.size(); ++i)
        triangles[i] = {indices[3 * i], indices[3 * i + 1], indices[3 * i + 2]};
    return triangles;
}

bool degenerate(const glm::uvec3& t) {
    return t.x == t.y || t.y == t.z || t.z == t.x;
}

/// Strips repeat indices to jump; those triangles are links, not geometry.
std::vector<glm::uvec3> triangles_from_strip(const Indices& indices) {
    std::vector<glm::uvec3> triangles;
    for (std::size_t i = 0; i + 2 < indices.size(); ++i) {
        const std::size_t odd = i & 1;
        const glm::uvec3 t{indices[i], indices[i + 1 + odd], indices[i + 2 - odd]};
        if (!degenerate(t))
            triangles.push_back(t);
    }
    return triangles;
}

std::vector<glm::uvec3> triangles_from_fan(const Indices& indices) {
    std::vector<glm::uvec3> triangles;
    for (std::size_t i = 1; i + 1 < indices.size(); ++i) {
        const glm::uvec3 t{indices[i], indices[i + 1], indices[0]};
        if (!degenerate(t))
            triangles.push_back(t);
    }
    return triangles;
}

template <typename Vector>
Vector vector_of(const std::vector<double>& values, const Vector& otherwise, const std::string& where) {
    if (values.empty())
        return otherwise;
    if (values.size() != static_cast<std::size_t>(Vector::length()))
        throw InputError(
            expected_found(where, std::to_string(Vector::length()) + " numbers", std::to_string(values.size())));
    Vector v;
    for (int i = 0; i < Vector::length(); ++i)
        v[i] = values[static_cast<std::size_t>(i)];
    return v;
}

glm::dmat4 local_transform(const tinygltf::Node& node, const std::string& where) {
    glm::dmat4 m(1);
    if (!node.matrix.empty()) {
        if (node.matrix.size() != 16)
            throw InputError(expected_found(where, "16 numbers as matrix", std::to_string(node.matrix.size())));
        for (int i = 0; i < 16; ++i)
            m[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
    } else {
        const auto t = vector_of(node.translation, glm::dvec3(0), where + " (translation)");
        const auto r = vector_of(node.rotation, glm::dvec4(0, 0, 0, 1), where + " (rotation)");
        const auto s = vector_of(node.scale, glm::dvec3(1), where + " (scale)");
        m = glm::translate(m, t) * glm::mat4_cast(glm::dquat(r.w, r.x, r.y, r.z)) * glm::scale(glm::dmat4(1), s);
    }
    for (int i = 0; i < 16; ++i)
        if (!std::isfinite(static_cast<float>(m[i / 4][i % 4])))
            throw InputError(expected_found(where, "a finite transform", "NaN or infinity in it"));
    return m;
}

class ModelReader {
public:
    ModelReader(const GltfDocument& document, const ModelOptions& options)
        : document_(document), gltf_(document.json()), options_(options) {}

    SceneModel read() {
        GltfMaterials materials = read_materials(document_, options_);
        texture_coordinates_ = std::move(materials.texture_coordinates);
        out_.materials = std::move(materials.materials);
        out_.textures = std::move(materials.textures);
        out_.alpha_masks = std::move(materials.alpha_masks);
        read_nodes();
        read_meshes();
        drop_empty_meshes();
        if (out_.instances.empty())
            throw InputError(expected_found(document_.file(), "at least one triangle", "none"));
        return std::move(out_);
    }

private:
    struct PrimitiveSource {
        std::size_t mesh;
        std::size_t primitive;
    };

    std::string where_primitive(const PrimitiveSource& source) const {
        return document_.where("mesh", source.mesh) + ", primitive " + std::to_string(source.primitive);
    }

    std::vector<int> root_nodes() const {
        if (!gltf_.scenes.empty()) {
            const int scene = std::max(0, gltf_.defaultScene);
            return gltf_.scenes[document_.checked(scene, gltf_.scenes.size(), document_.file(), "a scene")].nodes;
        }
        std::vector<bool> child(gltf_.nodes.size(), false);
        for (const auto& node : gltf_.nodes)
            for (const int c : node.children)
                child[document_.checked(c, child.size(), document_.file(), "a child node")] = true;
        std::vector<int> roots;
        for (std::size_t i = 0; i < child.size(); ++i)
            if (!child[i])
                roots.push_back(static_cast<int>(i));
        return roots;
    }

    /// Depth first without recursion; a node that is met twice means a cycle or two parents.
    void read_nodes() {
        out_.objects.resize(gltf_.nodes.size());
        std::vector<bool> met(gltf_.nodes.size(), false);
        std::vector<std::pair<int, int>> open;  // node, parent
        const std::vector<int> roots = root_nodes();
        for (auto root = roots.rbegin(); root != roots.rend(); ++root)
            open.emplace_back(*root, -1);
        std::vector<glm::dmat4> world(gltf_.nodes.size(), glm::dmat4(1));
        while (!open.empty()) {
            const auto [index, parent] = open.back();
            open.pop_back();
            const std::size_t n = document_.checked(index, gltf_.nodes.size(), document_.file(), "a node");
            const std::string where = document_.where("node", n);
            if (met[n])
                throw InputError(expected_found(where, "one parent", "several, or a cycle"));
            met[n] = true;
            const tinygltf::Node& node = gltf_.nodes[n];
            world[n] = local_transform(node, where);
            if (parent >= 0)
                world[n] = world[static_cast<std::size_t>(parent)] * world[n];
            out_.objects[n] = {node.name, parent, glm::mat4(world[n])};
            if (node.mesh >= 0)
                place_mesh(document_.checked(node.mesh, gltf_.meshes.size(), where, "a mesh"), n);
            for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
                open.emplace_back(*child, index);
        }
    }

    void place_mesh(std::size_t mesh, std::size_t node) {
        first_primitive_.resize(gltf_.meshes.size(), no_index);
        const auto& primitives = gltf_.meshes[mesh].primitives;
        if (first_primitive_[mesh] == no_index) {
            first_primitive_[mesh] = static_cast<std::uint32_t>(sources_.size());
            for (std::size_t p = 0; p < primitives.size(); ++p)
                sources_.push_back({mesh, p});
        }
        if (primitives.size() > instance_limit - out_.instances.size())
            throw InputError(expected_found(document_.file(), "at most 2^24 placements of meshes", "more"));
        for (std::size_t p = 0; p < primitives.size(); ++p)
            out_.instances.push_back({first_primitive_[mesh] + static_cast<std::uint32_t>(p),
                                      static_cast<std::uint32_t>(node), out_.objects[node].world_from_object});
    }

    void check_sizes() const {
        std::size_t vertices = 0;
        std::size_t indices = 0;
        std::size_t zeros = 0;
        for (const PrimitiveSource& source : sources_) {
            const tinygltf::Primitive& primitive = gltf_.meshes[source.mesh].primitives[source.primitive];
            if (const std::optional<Accessor> positions = attribute(primitive, "POSITION"))
                vertices += std::min(positions->count, element_limit);
            if (primitive.indices >= 0)
                indices += std::min(document_.accessor(primitive.indices).count, element_limit);
            if (vertices >= element_limit || indices >= element_limit)
                throw InputError(expected_found(document_.file(), "fewer than 2^28 vertices and indices", "more"));
            zeros += zero_elements(primitive);
            if (zeros > zero_element_limit)
                throw InputError(expected_found(
                    document_.file(), "at most 2^20 elements without a buffer view, of all meshes together", "more"));
        }
    }

    std::size_t zero_elements(const tinygltf::Primitive& primitive) const {
        std::size_t count = 0;
        const auto add = [&](int index) {
            const auto& accessor =
                gltf_.accessors[document_.checked(index, gltf_.accessors.size(), document_.file(), "an accessor")];
            count += accessor.bufferView < 0 ? std::min(accessor.count, element_limit) : 0;
        };
        for (const auto& attribute : primitive.attributes)
            add(attribute.second);
        if (primitive.indices >= 0)
            add(primitive.indices);
        return count;
    }

    void read_meshes() {
        check_sizes();
        out_.meshes.resize(sources_.size());
        tbb::parallel_for(std::size_t{0}, sources_.size(),
                          [this](std::size_t i) { out_.meshes[i] = read_mesh(sources_[i]); });
    }

    Mesh read_mesh(const PrimitiveSource& source) const {
        const tinygltf::Mesh& from = gltf_.meshes[source.mesh];
        const tinygltf::Primitive& primitive = from.primitives[source.primitive];
        const std::string where = where_primitive(source);
        Mesh to;
        to.name = from.name;
        if (from.primitives.size() > 1)
            to.name += "#" + std::to_string(source.primitive);
        const std::size_t count = gltf_.materials.size();
        to.material = static_cast<std::uint32_t>(
            primitive.material < 0 ? count : document_.checked(primitive.material, count, where, "a material"));

        const std::optional<Accessor> positions = attribute(primitive, "POSITION");
        if (!positions)
            throw InputError(expected_found(where, "a POSITION attribute", "none"));
        to.positions = read_vec3(*positions);
        to.triangles = read_triangles(primitive, to.positions.size(), where);
        const std::uint32_t mask = out_.materials[to.material].alpha_mask;
        if (mask != no_index && out_.alpha_masks[mask].opaque == std::vector<std::uint8_t>{0})
            to.triangles.clear();  // all of it is cut away, wherever its texture coordinates are
        if (options_.shading)
            if (const std::optional<Accessor> normals = attribute(primitive, "NORMAL"))
                to.normals = read_normals(*normals);
        read_uvs(primitive, to);
        require_length(to.normals.size(), to, where, "normals");
        require_length(to.uvs.size(), to, where, "texture coordinates");
        return to;
    }

    static void require_length(std::size_t length, const Mesh& mesh, const std::string& where, const char* what) {
        if (length != 0 && length != mesh.positions.size())
            throw InputError(
                expected_found(where, std::to_string(mesh.positions.size()) + " " + what, std::to_string(length)));
    }

    std::optional<Accessor> attribute(const tinygltf::Primitive& primitive, const std::string& name) const {
        const auto found = primitive.attributes.find(name);
        if (found == primitive.attributes.end())
            return std::nullopt;
        return document_.accessor(found->second);
    }

    static std::vector<glm::vec3> read_normals(const Accessor& accessor) {
        std::vector<glm::vec3> normals = read_vec3(accessor);
        for (glm::vec3& n : normals) {
            const float length = glm::length(n);
            n = length > 0 ? n / length : n;
        }
        return normals;
    }

    /// Only what something samples: the set its material's textures use, where they look it up.
    void read_uvs(const tinygltf::Primitive& primitive, Mesh& mesh) const {
        const TextureCoordinates& coordinates = texture_coordinates_[mesh.material];
        if (coordinates.set < 0)
            return;
        if (const std::optional<Accessor> uvs = attribute(primitive, "TEXCOORD_" + std::to_string(coordinates.set)))
            mesh.uvs = read_vec2(*uvs);
        if (coordinates.is_moved())
            for (glm::vec2& uv : mesh.uvs)
                uv = coordinates.moved(uv);
    }

    std::vector<glm::uvec3> read_triangles(const tinygltf::Primitive& primitive, std::size_t vertices,
                                           const std::string& where) const {
        Indices indices;
        if (primitive.indices >= 0) {
            indices = read_indices(document_.accessor(primitive.indices));
        } else {
            indices.resize(vertices);
            for (std::size_t i = 0; i < vertices; ++i)
                indices[i] = static_cast<std::uint32_t>(i);
        }
        for (const std::uint32_t index : indices)
            if (index >= vertices)
                throw InputError(
                    expected_found(where, "indices below " + std::to_string(vertices), std::to_string(index)));
        switch (primitive.mode) {
        case TINYGLTF_MODE_TRIANGLES:
        case -1:
            return triangles_from_list(indices, where);
        case TINYGLTF_MODE_TRIANGLE_STRIP:
            return triangles_from_strip(indices);
        case TINYGLTF_MODE_TRIANGLE_FAN:
            return triangles_from_fan(indices);
        default:
            return {};  // points and lines have no surface
        }
    }

    void drop_empty_meshes() {
        std::erase_if(out_.instances, [this](const Instance& i) { return out_.meshes[i.mesh].triangles.empty(); });
    }

    const GltfDocument& document_;
    const tinygltf::Model& gltf_;
    const ModelOptions& options_;
    SceneModel out_;
    std::vector<TextureCoordinates> texture_coordinates_;  ///< by material
    std::vector<PrimitiveSource> sources_;
    std::vector<std::uint32_t> first_primitive_;  ///< by glTF mesh: its first entry in sources_
};

}  // namespace

SceneModel load_gltf(const std::filesystem::path& file, const ModelOptions& options) {
    const GltfDocument document(file);
    SceneModel model = ModelReader(document, options).read();
    if (std::string note = left_out_note(document, options); !note.empty())
        model.notes.push_back(std::move(note));
    return model;
}

}  // namespace equistream
