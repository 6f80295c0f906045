#include "obj_document.h"
#include "obj_materials.h"

#include <equistream/error.h>

#include <bit>
#include <cmath>
#include <unordered_map>

namespace equistream {

namespace {

/// Numbers what it is given, equal things alike: an open hash table of indices into what there is so far.
class CornerIndex {
public:
    explicit CornerIndex(std::size_t most) : table_(std::bit_ceil(2 * most + 2), no_index) {
        unique_.reserve(most / 2);
    }

    std::uint32_t number(const ObjCorner& corner) {
        for (std::size_t slot = hash(corner);; ++slot) {
            std::uint32_t& entry = table_[slot & (table_.size() - 1)];
            if (entry == no_index) {
                entry = static_cast<std::uint32_t>(unique_.size());
                unique_.push_back(corner);
                return entry;
            }
            if (unique_[entry] == corner)
                return entry;
        }
    }
    const std::vector<ObjCorner>& unique() const { return unique_; }

private:
    static std::size_t hash(const ObjCorner& c) {
        std::uint64_t h = c.position * 0x9e3779b97f4a7c15ull;
        h = (h ^ (h >> 29) ^ c.uv) * 0xbf58476d1ce4e5b9ull;
        h = (h ^ (h >> 32) ^ c.normal) * 0x94d049bb133111ebull;
        return static_cast<std::size_t>(h ^ (h >> 31));
    }
    std::vector<std::uint32_t> table_;
    std::vector<ObjCorner> unique_;
};

/// Normals for corners without one: a triangle's own where its smoothing is off, else the mean over the triangles of
/// the group around the vertex, each weighted by its angle there. Zero where triangles back to back cancel each other.
class MissingNormals {
public:
    /// What such triangles leave is rounding.
    static constexpr float min_normal_length = 1e-4f;

    explicit MissingNormals(ObjDocument& document) : document_(document) {}

    void add() {
        for (const ObjPart& part : document_.parts)
            sum_smooth(part);
        for (auto& [key, index] : index_of_) {
            glm::vec3& n = document_.normals[index];
            const float length = glm::length(n);
            n = length > min_normal_length ? n / length : glm::vec3(0);
        }
        for (ObjPart& part : document_.parts)
            assign(part);
    }

private:
    glm::dvec3 position(const ObjCorner& corner) const { return document_.positions[corner.position]; }

    static std::uint64_t key_of(const ObjCorner& corner, std::uint32_t group) {
        return std::uint64_t{group} << 32 | corner.position;
    }

    void sum_smooth(const ObjPart& part) {
        for (std::size_t t = 0; t < part.smoothing_groups.size(); ++t) {
            const std::uint32_t group = part.smoothing_groups[t];
            const ObjCorner* corners = &part.corners[3 * t];
            if (group == 0)
                continue;
            const glm::dvec3 normal = unit_normal(corners);
            for (std::size_t i = 0; i < 3; ++i) {
                if (corners[i].normal != no_index)
                    continue;
                const glm::dvec3 a = position(corners[(i + 1) % 3]) - position(corners[i]);
                const glm::dvec3 b = position(corners[(i + 2) % 3]) - position(corners[i]);
                const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
                const auto [entry, added] = index_of_.try_emplace(key_of(corners[i], group), document_.normals.size());
                if (added)
                    document_.normals.emplace_back(0);
                document_.normals[entry->second] += glm::vec3(angle * normal);
            }
        }
    }

    void assign(ObjPart& part) {
        if (!wants_normals(part))
            return;
        for (std::size_t t = 0; t < part.smoothing_groups.size(); ++t) {
            const std::uint32_t group = part.smoothing_groups[t];
            ObjCorner* corners = &part.corners[3 * t];
            std::uint32_t flat = no_index;
            for (std::size_t i = 0; i < 3; ++i) {
                if (corners[i].normal != no_index)
                    continue;
                if (group != 0) {
                    corners[i].normal = index_of_.at(key_of(corners[i], group));
                } else {
                    if (flat == no_index) {
                        flat = static_cast<std::uint32_t>(document_.normals.size());
                        document_.normals.emplace_back(unit_normal(corners));
                    }
                    corners[i].normal = flat;
                }
            }
        }
    }

    /// A mesh of flat triangles alone goes without: a renderer takes the triangles' own.
    static bool wants_normals(const ObjPart& part) {
        for (const ObjCorner& corner : part.corners)
            if (corner.normal != no_index)
                return true;
        for (const std::uint32_t group : part.smoothing_groups)
            if (group != 0)
                return true;
        return false;
    }

    glm::dvec3 unit_normal(const ObjCorner* corners) const {
        const glm::dvec3 a = position(corners[0]);
        return glm::normalize(glm::cross(position(corners[1]) - a, position(corners[2]) - a));
    }

    ObjDocument& document_;
    std::unordered_map<std::uint64_t, std::uint32_t> index_of_;
};

class ModelBuilder {
public:
    ModelBuilder(ObjDocument document, const ModelOptions& options, ObjNotes& notes)
        : document_(std::move(document)), options_(options), notes_(notes) {}

    SceneModel build() {
        std::vector<bool> used(document_.materials.size() + 1, false);
        for (const ObjPart& part : document_.parts)
            used[part.material] = true;
        materials_ = convert_materials(document_.materials, used, options_, notes_);
        if (options_.shading)
            MissingNormals(document_).add();
        for (ObjPart& part : document_.parts)
            add_mesh(part);
        if (out_.meshes.empty())
            throw InputError(expected_found(document_.file, "at least one triangle", "none"));
        out_.objects = std::move(document_.objects);
        out_.materials = std::move(materials_.materials);
        out_.textures = std::move(materials_.textures);
        out_.alpha_masks = std::move(materials_.alpha_masks);
        return std::move(out_);
    }

private:
    void add_mesh(ObjPart& part) {
        if (part.corners.empty())
            return;
        const bool with_uvs = materials_.textured[part.material];
        CornerIndex index(part.corners.size());
        Mesh mesh;
        mesh.name = document_.objects[part.object].name + "#" + materials_.materials[part.material].name;
        mesh.material = part.material;
        mesh.triangles.reserve(part.corners.size() / 3);
        bool any_uv = false;
        for (std::size_t i = 0; i < part.corners.size(); i += 3) {
            glm::uvec3 triangle;
            for (int k = 0; k < 3; ++k) {
                ObjCorner corner = part.corners[i + static_cast<std::size_t>(k)];
                if (!with_uvs)
                    corner.uv = no_index;
                if (!options_.shading)
                    corner.normal = no_index;
                any_uv = any_uv || corner.uv != no_index;
                triangle[k] = index.number(corner);
            }
            mesh.triangles.push_back(triangle);
        }
        fill(index.unique(), any_uv, mesh);
        out_.instances.push_back({static_cast<std::uint32_t>(out_.meshes.size()), part.object, glm::mat4(1)});
        out_.meshes.push_back(std::move(mesh));
        part = {};  // what is large is given back as soon as it has been used
    }

    void fill(const std::vector<ObjCorner>& corners, bool with_uvs, Mesh& mesh) const {
        const bool with_normals = corners.front().normal != no_index;
        const glm::vec2 scale = materials_.uv_scale[mesh.material], offset = materials_.uv_offset[mesh.material];
        // Room for one more: Embree may read 16 bytes at the last one.
        mesh.positions.reserve(corners.size() + 1);
        mesh.normals.reserve(with_normals ? corners.size() + 1 : 0);
        mesh.uvs.reserve(with_uvs ? corners.size() + 1 : 0);
        for (const ObjCorner& corner : corners) {
            mesh.positions.push_back(document_.positions[corner.position]);
            if (with_normals)
                mesh.normals.push_back(unit(document_.normals[corner.normal]));
            if (with_uvs) {
                const glm::vec2 uv = corner.uv == no_index ? glm::vec2(0) : document_.uvs[corner.uv] * scale + offset;
                mesh.uvs.emplace_back(uv.x, 1 - uv.y);
            }
        }
    }

    static glm::vec3 unit(const glm::vec3& n) {
        const float length = glm::length(n);
        return length > 0 && std::isfinite(length) ? n / length : glm::vec3(0);
    }

    ObjDocument document_;
    const ModelOptions& options_;
    ObjNotes& notes_;
    ObjMaterials materials_;
    SceneModel out_;
};

}  // namespace

SceneModel load_obj(const std::filesystem::path& file, const ModelOptions& options) {
    ObjNotes notes;
    ObjDocument document = read_obj(file, notes);
    SceneModel model = ModelBuilder(std::move(document), options, notes).build();
    model.notes = notes.lines();
    return model;
}

}  // namespace equistream
