#include "shapes.h"

#include "xml.h"

#include <equistream/rec709.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace equistream::mitsuba_xml {
namespace {

/// Mitsuba lets a light shine where its shading normal looks, ours where its triangles do: vertex normals that differ
/// by more than 3 degrees are left out of lights.
constexpr double min_cosine_of_lights = 0.9986;

/// Apart enough for floats, and less than any ray's offset from the surface that it leaves.
double gap_between_sides(double coordinate_m) {
    return 1e-5 * (1 + coordinate_m);
}

std::string mesh_file(const std::string& name) {
    return name + ".ply";
}

std::string numbered(const char* what, std::size_t index) {
    return what + std::to_string(index);
}

double max_coordinate(const Mesh& mesh, const glm::mat4& transform) {
    double largest = 0;
    for (const glm::vec3& p : mesh.positions) {
        const glm::dvec3 world(glm::dmat4(transform) * glm::dvec4(glm::dvec3(p), 1));
        largest = std::max({largest, std::abs(world.x), std::abs(world.y), std::abs(world.z)});
    }
    return largest;
}

}  // namespace

Shapes::Shapes(const SceneModel& model, const std::vector<glm::mat4>& transforms,
               const std::vector<std::uint32_t>& moving, Materials& materials, bool bake)
    : model_(model), transforms_(transforms), materials_(materials), forms_(model.instances.size(), Form::instance),
      grouped_(model.meshes.size(), 0) {
    std::vector<std::uint32_t> placements(model.meshes.size(), 0);
    for (const Instance& instance : model.instances)
        ++placements[instance.mesh];
    for (std::uint32_t i = 0; i < forms_.size(); ++i) {
        const Mesh& mesh = mesh_of(i);
        materials_.id_for(mesh);
        if (model.materials[materials_.index_for(mesh)].emission != glm::vec3(0))
            forms_[i] = Form::glowing;
        else if ((bake || placements[model.instances[i].mesh] == 1) &&
                 !std::binary_search(moving.begin(), moving.end(), i))
            forms_[i] = Form::baked;
        else
            grouped_[model.instances[i].mesh] = 1;
    }
    if (bake)
        merge();
}

void Shapes::merge() {
    std::map<std::pair<std::string, bool>, std::vector<std::uint32_t>> by_look;
    for (std::uint32_t i = 0; i < forms_.size(); ++i)
        if (forms_[i] == Form::baked) {
            forms_[i] = Form::merged;
            const Mesh& mesh = mesh_of(i);
            by_look[{materials_.id_for(mesh), mesh.normals.empty()}].push_back(i);
        }
    for (auto& [look, instances] : by_look)
        merged_.push_back(std::move(instances));
}

PlyPart Shapes::part_of(std::uint32_t instance) const {
    return {&mesh_of(instance), transforms_[instance], instance};
}

Bounds Shapes::bounds() const {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (std::size_t i = 0; i < forms_.size(); ++i)
        for (const glm::vec3& p : mesh_of(static_cast<std::uint32_t>(i)).positions) {
            const glm::dvec3 world(transforms_[i] * glm::vec4(p, 1));
            low = glm::min(low, world);
            high = glm::max(high, world);
        }
    return {0.5 * (low + high), 0.5 * glm::length(high - low)};
}

double Shapes::power_of(std::uint32_t instance) const {
    const Mesh& mesh = mesh_of(instance);
    const glm::dmat3 linear(transforms_[instance]);
    double area = 0;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a(mesh.positions[t.x]);
        area += 0.5 * glm::length(glm::cross(linear * (glm::dvec3(mesh.positions[t.y]) - a),
                                             linear * (glm::dvec3(mesh.positions[t.z]) - a)));
    }
    return area * luminance(glm::dvec3(model_.materials[materials_.index_for(mesh)].emission));
}

bool Shapes::wants_coordinates(const Mesh& mesh) const {
    const Material& m = model_.materials[materials_.index_for(mesh)];
    return m.base_colour_texture != no_index || m.metallic_roughness_texture != no_index ||
           m.emission_texture != no_index || m.alpha_mask != no_index;
}

std::string Shapes::emission_image(const Mesh& mesh, Images& images) const {
    const Material& material = model_.materials[materials_.index_for(mesh)];
    const std::uint32_t mask = model_.mask_of(mesh);
    if (material.emission_texture == no_index && mask == no_index)
        return {};
    return images.emission(material.emission_texture, material.emission, mask);
}

void Shapes::ask_for_images(Images& images) const {
    for (std::uint32_t i = 0; i < forms_.size(); ++i)
        if (forms_[i] == Form::glowing)
            emission_image(mesh_of(i), images);
}

void Shapes::write_glowing(AssetFolder& folder, std::uint32_t instance) const {
    const Mesh& mesh = mesh_of(instance);
    const std::string name = numbered("instance-", instance);
    const PlyPart part = part_of(instance);
    PlyOptions options;
    options.texture_coordinates = wants_coordinates(mesh);
    options.normals = min_normal_cosine(mesh) > min_cosine_of_lights;
    write_ply(folder, mesh_file(name), {&part, 1}, options);
    if (!model_.materials[materials_.index_for(mesh)].double_sided)
        return;
    options.behind_m = gap_between_sides(max_coordinate(mesh, transforms_[instance]));
    write_ply(folder, mesh_file(name + "-back"), {&part, 1}, options);
}

void Shapes::write_meshes(AssetFolder& folder) const {
    tbb::parallel_for(std::size_t{0}, grouped_.size(), [&](std::size_t i) {
        const PlyPart part{&model_.meshes[i]};
        if (grouped_[i])
            write_ply(folder, mesh_file(numbered("mesh-", i)), {&part, 1},
                      {.texture_coordinates = wants_coordinates(model_.meshes[i])});
    });
    tbb::parallel_for(std::size_t{0}, forms_.size(), [&](std::size_t i) {
        const auto instance = static_cast<std::uint32_t>(i);
        if (forms_[i] == Form::glowing)
            return write_glowing(folder, instance);
        const PlyPart part = part_of(instance);
        if (forms_[i] == Form::baked)
            write_ply(folder, mesh_file(numbered("instance-", i)), {&part, 1},
                      {.texture_coordinates = wants_coordinates(*part.mesh)});
    });
    tbb::parallel_for(std::size_t{0}, merged_.size(), [&](std::size_t i) {
        std::vector<PlyPart> parts;
        for (const std::uint32_t instance : merged_[i])
            parts.push_back(part_of(instance));
        write_ply(folder, mesh_file(numbered("merged-", i)), parts,
                  {.texture_coordinates = wants_coordinates(*parts.front().mesh), .instances = true});
    });
}

void Shapes::declare_ply(pugi::xml_node parent, const std::string& id, const std::string& reference, const Mesh& mesh,
                         bool smooth) {
    pugi::xml_node node = add_plugin(parent, "shape", "ply", id);
    add_text(node, "filename", reference);
    if (!smooth)
        add_boolean(node, "face_normals", true);
    add_reference(node, materials_.id_for(mesh));
}

void Shapes::declare_glowing(pugi::xml_node scene, const AssetFolder& folder, std::uint32_t instance,
                             const Glow& glow) {
    const Mesh& mesh = mesh_of(instance);
    const Material& material = model_.materials[materials_.index_for(mesh)];
    const bool smooth = !mesh.normals.empty() && min_normal_cosine(mesh) > min_cosine_of_lights;
    for (int side = 0; side < (glow.both_sides ? 2 : 1); ++side) {
        const std::string id = numbered("instance-", instance) + (side == 0 ? "" : "-back");
        declare_ply(scene, id, folder.reference_to(mesh_file(id)), mesh, smooth);
        add_emitter(scene.last_child(), material, glow.image, glow.share / (glow.both_sides ? 2 : 1));
    }
}

void Shapes::declare(pugi::xml_node scene, const AssetFolder& folder, Images& images) {
    for (std::size_t i = 0; i < grouped_.size(); ++i)
        if (grouped_[i]) {
            pugi::xml_node group = add_plugin(scene, "shape", "shapegroup", numbered("mesh-", i));
            declare_ply(group, "", folder.reference_to(mesh_file(numbered("mesh-", i))), model_.meshes[i],
                        !model_.meshes[i].normals.empty());
        }
    for (std::size_t i = 0; i < merged_.size(); ++i) {
        const Mesh& first = mesh_of(merged_[i].front());
        const std::string id = numbered("merged-", i);
        declare_ply(scene, id, folder.reference_to(mesh_file(id)), first, !first.normals.empty());
    }
    double power = 0;
    for (std::uint32_t i = 0; i < forms_.size(); ++i)
        power += forms_[i] == Form::glowing ? power_of(i) : 0;
    for (std::uint32_t i = 0; i < forms_.size(); ++i) {
        const std::string id = numbered("instance-", i);
        const Mesh& mesh = mesh_of(i);
        if (forms_[i] == Form::instance) {
            pugi::xml_node node = add_plugin(scene, "shape", "instance", id);
            add_reference(node, numbered("mesh-", model_.instances[i].mesh));
            add_transform(node, "to_world", transforms_[i]);
        } else if (forms_[i] == Form::merged) {
            continue;
        } else if (forms_[i] == Form::baked) {
            declare_ply(scene, id, folder.reference_to(mesh_file(id)), mesh, !mesh.normals.empty());
        } else {
            Glow glow{emission_image(mesh, images), power > 0 ? power_of(i) / power : 0,
                      model_.materials[materials_.index_for(mesh)].double_sided};
            if (!glow.image.empty() && !maps_one_to_one(mesh))
                glow.share = 0;
            ++(glow.share > 0 ? sampled_glows_ : unsampled_glows_);
            declare_glowing(scene, folder, i, glow);
        }
    }
}

void Shapes::report(MitsubaReport& to) const {
    for (const Form form : forms_)
        if (form != Form::merged)
            (form == Form::instance ? to.instances : to.shapes) += 1;
    to.shapes += merged_.size();
    for (const std::uint8_t grouped : grouped_)
        to.groups += grouped;
    if (unsampled_glows_ > 0)
        to.notes.push_back(
            std::to_string(unsampled_glows_) +
            " textured lights repeat their texture: Mitsuba finds them by scattered rays alone, with more noise");
}

}  // namespace equistream::mitsuba_xml
