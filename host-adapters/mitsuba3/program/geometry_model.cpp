#include "geometry_model.h"

#include "path_distance.h"
#include "tessellate.h"

#include <equistream/bound.h>
#include <equistream/error.h>

#include <stb/stb_image_write.h>

#include <algorithm>
#include <map>

namespace equistream::mitsuba_host {
namespace {

/// Of the budget: geometry's quarter, and of that a sixteenth, so that rays at four degrees to the surface keep to it
/// too.
constexpr double share = default_budget_share / 16;
constexpr std::size_t max_notes = 20;

class Exporter {
public:
    Exporter(EmbeddedScene& scene, const WorldMap& world, const HeadBox& box)
        : scene_(scene), world_(world), radius_m_(box.radius_m), path_(box.path) {
        Material surface;
        surface.name = "surface";
        surface.metallic = 0;
        surface.double_sided = true;
        result_.model.materials.push_back(surface);
    }

    GeometryModel run() {
        const auto& shapes = scene_.shapes();
        for (std::size_t i = 0; i < shapes.size(); ++i)
            if (shapes[i].group >= 0)
                placements_[shapes[i].group].push_back(world_.transform(shapes[i].to_world));
        for (std::size_t i = 0; i < shapes.size(); ++i) {
            const std::vector<std::uint32_t> meshes =
                shapes[i].group >= 0 ? group_meshes(shapes[i].group) : shape_meshes(-1, i, shapes[i]);
            const glm::mat4 place =
                shapes[i].group >= 0 ? glm::mat4(world_.transform(shapes[i].to_world)) : glm::mat4(1);
            if (!meshes.empty())
                add_object(shapes[i].id, place, meshes);
        }
        if (left_out_ > max_notes)
            result_.notes.push_back(std::to_string(left_out_ - max_notes) + " more shapes are not in scene.glb");
        return std::move(result_);
    }

private:
    void add_object(const std::string& name, const glm::mat4& place, const std::vector<std::uint32_t>& meshes) {
        const auto object = static_cast<std::uint32_t>(result_.model.objects.size());
        result_.model.objects.push_back({name, -1, place});
        for (const std::uint32_t mesh : meshes)
            result_.model.instances.push_back({mesh, object, place});
    }

    std::vector<std::uint32_t> group_meshes(int group) {
        const auto [entry, is_new] = groups_.try_emplace(group);
        if (is_new) {
            const auto& shapes = scene_.groups()[static_cast<std::size_t>(group)].shapes;
            for (std::size_t i = 0; i < shapes.size(); ++i)
                for (const std::uint32_t mesh : shape_meshes(group, i, shapes[i]))
                    entry->second.push_back(mesh);
        }
        return entry->second;
    }

    /// One mesh or, for what no ray stops at or nobody can export, none.
    std::vector<std::uint32_t> shape_meshes(int group, std::size_t index, const ShapeSummary& shape) {
        if (shape.is_invisible)
            return {};
        Mesh mesh;
        if (shape.is_mesh) {
            mesh = from_buffers(scene_.mesh(group, index));
        } else if (is_analytic(shape.class_name)) {
            mesh = analytic(group, shape);
        } else {
            if (left_out_++ < max_notes)
                result_.notes.push_back("shape \"" + shape.id + "\" (" + shape.class_name +
                                        ") has no triangles and is not in scene.glb");
            return {};
        }
        if (mesh.triangles.empty() || !set_material(group, index, shape, mesh))
            return {};
        mesh.name = shape.id;
        result_.model.meshes.push_back(std::move(mesh));
        return {static_cast<std::uint32_t>(result_.model.meshes.size() - 1)};
    }

    Mesh from_buffers(const MeshBuffers& buffers) const {
        Mesh mesh;
        for (std::size_t i = 0; i + 2 < buffers.positions.size(); i += 3)
            mesh.positions.emplace_back(
                world_.point({buffers.positions[i], buffers.positions[i + 1], buffers.positions[i + 2]}));
        for (std::size_t i = 0; i + 2 < buffers.normals.size(); i += 3)
            mesh.normals.emplace_back(world_.ours_from_mitsuba *
                                      glm::dvec3(buffers.normals[i], buffers.normals[i + 1], buffers.normals[i + 2]));
        for (std::size_t i = 0; i + 1 < buffers.texture_coordinates.size(); i += 2)
            mesh.uvs.emplace_back(buffers.texture_coordinates[i], buffers.texture_coordinates[i + 1]);
        for (std::size_t i = 0; i + 2 < buffers.triangles.size(); i += 3)
            mesh.triangles.emplace_back(buffers.triangles[i], buffers.triangles[i + 1], buffers.triangles[i + 2]);
        return mesh;
    }

    /// From what Mitsuba calls the shape's own space to ours, or to its group's in our axes.
    glm::dmat4 ours_from_shape(const ShapeSummary& shape) const {
        const glm::dmat4 map(glm::dmat3(world_.metres_per_unit * world_.ours_from_mitsuba));
        return map * matrix_of(shape.to_world);
    }

    Mesh analytic(int group, const ShapeSummary& shape) {
        const glm::dmat4 own = ours_from_shape(shape);
        const Mesh coarse = tessellate(shape.class_name, own, 1e9).mesh;
        double tolerance = 1e30;
        if (group < 0)
            tolerance = tolerance_m(coarse, glm::dmat4(1));
        else
            for (const glm::dmat4& place : placements_[group])
                tolerance = std::min(tolerance, tolerance_m(coarse, place));
        Tessellation fine = tessellate(shape.class_name, own, tolerance);
        if (fine.coarser && left_out_++ < max_notes)
            result_.notes.push_back(
                "shape \"" + shape.id + "\" (" + shape.class_name +
                ") is coarser in scene.glb than the error bound allows: the head comes very near it");
        return std::move(fine.mesh);
    }

    /// What the bound grants, in the space of `mesh`. The nearest point may lie between coarse vertices: a hundredth of
    /// the shape's size is the least distance that counts.
    double tolerance_m(const Mesh& mesh, const glm::dmat4& place) const {
        double nearest = 1e30, size = 0;
        const glm::dvec3 first(place * glm::dvec4(mesh.positions.front(), 1));
        for (const glm::vec3& position : mesh.positions) {
            const glm::dvec3 p(place * glm::dvec4(position, 1));
            size = std::max(size, glm::length(p - first));
            nearest = std::min(nearest, path_.metres_to(p));
        }
        const double scale = std::max({glm::length(glm::dvec3(place[0])), glm::length(glm::dvec3(place[1])),
                                       glm::length(glm::dvec3(place[2])), 1e-30});
        return share * error_budget_rad(default_focal_length_px) *
               std::max(nearest - radius_m_, 0.01 * std::max(size, 1e-6)) / scale;
    }

    /// False where the whole shape is cut away.
    bool set_material(int group, std::size_t index, const ShapeSummary& shape, Mesh& mesh) {
        mesh.material = 0;
        if (const auto known = masks_.find(shape.bsdf); known != masks_.end()) {
            mesh.material = known->second;
            return true;
        }
        const OpacityMap map = scene_.opacity(group, index);
        if (map.width == 0)
            return true;
        const auto covers = [](float opacity) { return opacity >= 0.5f; };
        if (std::none_of(map.opacity.begin(), map.opacity.end(), covers))
            return false;
        if (std::all_of(map.opacity.begin(), map.opacity.end(), covers))
            return true;
        if (mesh.uvs.empty()) {
            result_.notes.push_back("shape \"" + shape.id + "\" has a mask but no texture coordinates that can be " +
                                    "exported: scene.glb has it without the mask");
            return true;
        }
        mesh.material = add_mask(shape.bsdf, map);
        return true;
    }

    std::uint32_t add_mask(const std::string& bsdf, const OpacityMap& map) {
        SceneModel& model = result_.model;
        Texture texture;
        texture.name = "opacity of " + bsdf;
        texture.mime_type = "image/png";
        texture.encoded = mask_png(map);
        texture.nearest = true;
        model.textures.push_back(std::move(texture));
        AlphaMask mask;  // the writer asks only whether there is one; what it holds is the texture's alpha
        model.alpha_masks.push_back(mask);
        Material material = model.materials.front();
        material.name = bsdf;
        material.base_colour_texture = static_cast<std::uint32_t>(model.textures.size() - 1);
        material.alpha_mask = static_cast<std::uint32_t>(model.alpha_masks.size() - 1);
        model.materials.push_back(material);
        return masks_[bsdf] = static_cast<std::uint32_t>(model.materials.size() - 1);
    }

    EmbeddedScene& scene_;
    const WorldMap& world_;
    double radius_m_;
    PathDistance path_;
    std::map<int, std::vector<glm::dmat4>> placements_;  // of groups
    std::map<int, std::vector<std::uint32_t>> groups_;   // their meshes
    std::map<std::string, std::uint32_t> masks_;         // materials by the BSDF's id
    std::size_t left_out_ = 0;
    GeometryModel result_;
};

}  // namespace

GeometryModel geometry_model(EmbeddedScene& scene, const WorldMap& world, const HeadBox& box) {
    return Exporter(scene, world, box).run();
}

std::vector<std::uint8_t> mask_png(const OpacityMap& map) {
    std::vector<std::uint8_t> rgba(4 * map.opacity.size(), 255);
    for (std::size_t i = 0; i < map.opacity.size(); ++i)
        rgba[4 * i + 3] = map.opacity[i] >= 0.5f ? 255 : 0;
    std::vector<std::uint8_t> png;
    const auto append = [](void* to, void* data, int size) {
        auto& bytes = *static_cast<std::vector<std::uint8_t>*>(to);
        const auto* first = static_cast<const std::uint8_t*>(data);
        bytes.insert(bytes.end(), first, first + size);
    };
    if (stbi_write_png_to_func(append, &png, map.width, map.height, 4, rgba.data(), 4 * map.width) == 0)
        throw WorkError("an opacity map could not be coded as PNG");
    return png;
}

}  // namespace equistream::mitsuba_host
