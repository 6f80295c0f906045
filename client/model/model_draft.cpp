#include "model_draft.h"

#include "client_model.h"
#include "simplify.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace equistream {

namespace {

/// No name of a node of the user's, which moving objects are found by.
constexpr const char* own_name = "equistream model";
/// An instance this strict is placed with its mesh as it is.
constexpr int exact_log4 = std::numeric_limits<int>::min();

void tighten(std::uint8_t& strictness) {
    strictness = std::min<std::uint8_t>(StaticGeometry::exact, std::uint8_t(strictness + 1));
}

double max_scale(const glm::mat4& m) {
    return std::max({glm::length(glm::vec3(m[0])), glm::length(glm::vec3(m[1])), glm::length(glm::vec3(m[2]))});
}

}  // namespace

ModelDraft::ModelDraft(const SceneModel& scene, const SceneDescription& description, const HeadBoxes& boxes,
                       double error_rad)
    : scene_(scene), description_(description), boxes_(boxes), error_rad_(error_rad),
      part_(scene.instances.size(), Part::placed), moving_(scene.instances.size(), false),
      strictness_(scene.instances.size(), 0) {
    std::vector<int> placements(scene.meshes.size(), 0);
    for (const Instance& instance : scene.instances)
        ++placements[instance.mesh];
    for (const std::uint32_t i : find_moving_instances(scene, description))
        moving_[i] = true;
    first_vertex_.assign(scene.instances.size(), 0);
    std::vector<glm::vec3> world;
    for (std::size_t i = 0; i < part_.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (moving_[i] || scene.mask_of(mesh) != no_index)
            part_[i] = Part::exact;
        else if (placements[instance.mesh] == 1)
            part_[i] = Part::merged;
        if (part_[i] != Part::merged)
            continue;
        first_vertex_[i] = world.size();
        for (const glm::vec3& p : mesh.positions)
            world.push_back(glm::vec3(instance.world_from_object * glm::vec4(p, 1)));
    }
    points_ = weld(world);
    for (std::size_t v = 0; v < points_.size(); ++v)
        if (points_[v] == merged_.positions.size())
            merged_.positions.push_back(world[v]);
    merged_.strictness.assign(merged_.positions.size(), 0);
}

void ModelDraft::keep(SeenTriangles seen) {
    kept_ = std::move(seen);
    std::vector<std::uint8_t> touched(merged_.positions.size(), 0);
    const auto each_corner = [&](std::size_t i, auto&& act) {
        const Mesh& mesh = scene_.meshes[scene_.instances[i].mesh];
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (int corner = 0; corner < 3; ++corner)
                act(kept_[i][t], touched[points_[first_vertex_[i] + mesh.triangles[t][corner]]]);
    };
    for (std::size_t i = 0; i < part_.size(); ++i) {
        if (moving_[i])
            std::fill(kept_[i].begin(), kept_[i].end(), 1);
        else if (part_[i] == Part::merged)
            each_corner(i, [](std::uint8_t kept, std::uint8_t& point) { point |= kept; });
        else
            add_neighbours(scene_.meshes[scene_.instances[i].mesh], kept_[i]);
    }
    for (std::size_t i = 0; i < part_.size(); ++i)
        if (part_[i] == Part::merged)
            each_corner(i, [](std::uint8_t& kept, std::uint8_t point) { kept |= point; });
}

std::uint64_t ModelDraft::kept_triangles() const {
    std::uint64_t count = 0;
    for (const std::vector<std::uint8_t>& of_instance : kept_)
        count += std::uint64_t(std::count(of_instance.begin(), of_instance.end(), 1));
    return count;
}

SceneModel ModelDraft::build() {
    SceneModel out;
    source_instance_.clear();
    new_material_.assign(scene_.materials.size(), no_index);
    out.materials.resize(1);
    out.materials[0].name = own_name;
    copy_moving_objects(out);
    build_merged(out);
    build_placed(out);
    build_exact(out);
    return out;
}

void ModelDraft::copy_moving_objects(SceneModel& out) {
    new_object_.assign(scene_.objects.size(), no_index);
    for (std::size_t i = 0; i < scene_.instances.size(); ++i)
        for (int o = moving_[i] ? int(scene_.instances[i].object) : -1; o >= 0;
             o = scene_.objects[std::size_t(o)].parent)
            new_object_[std::size_t(o)] = 0;
    for (std::size_t o = 0; o < new_object_.size(); ++o)
        if (new_object_[o] != no_index) {
            new_object_[o] = std::uint32_t(out.objects.size());
            out.objects.push_back(scene_.objects[o]);
        }
    for (Object& object : out.objects)
        if (object.parent >= 0)
            object.parent = int(new_object_[std::size_t(object.parent)]);
}

void ModelDraft::build_merged(SceneModel& out) {
    merged_.triangles.clear();
    for (std::size_t i = 0; i < part_.size(); ++i) {
        if (part_[i] != Part::merged)
            continue;
        const Mesh& mesh = scene_.meshes[scene_.instances[i].mesh];
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const glm::uvec3 v = mesh.triangles[t];
            const auto point = [&](unsigned index) { return points_[first_vertex_[i] + index]; };
            const glm::uvec3 welded{point(v.x), point(v.y), point(v.z)};
            if (kept_[i][t] != 0 && welded.x != welded.y && welded.y != welded.z && welded.z != welded.x)
                merged_.triangles.push_back(welded);
        }
    }
    merged_triangles_ = simplified(merged_, boxes_, error_rad_);
    if (merged_triangles_.empty())
        return;
    Mesh all;
    all.name = own_name;
    all.material = 0;
    all.positions = merged_.positions;
    out.meshes.push_back(part_of(all, merged_triangles_));
    out.instances.push_back({std::uint32_t(out.meshes.size() - 1), std::uint32_t(out.objects.size()), glm::mat4(1)});
    out.objects.push_back({own_name, -1, glm::mat4(1)});
    source_instance_.push_back(no_index);
}

int ModelDraft::allowed_log4(std::uint32_t instance) const {
    const Instance& placed = scene_.instances[instance];
    const Mesh& mesh = scene_.meshes[placed.mesh];
    if (strictness_[instance] >= StaticGeometry::exact)
        return exact_log4;
    double allowed = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (kept_[instance][t] == 0)
            continue;
        const TriangleCorners corners = corners_of(mesh, t, placed.world_from_object);
        allowed = std::min(allowed, boxes_.allowed_m(corners, boxes_.distance_m(corners), error_rad_));
    }
    const double own_space = allowed / max_scale(placed.world_from_object);
    return own_space > 0 ? int(std::floor(0.5 * std::log2(own_space))) - strictness_[instance] : exact_log4;
}

std::vector<glm::uvec3> ModelDraft::kept_of_mesh(const std::vector<std::uint32_t>& instances) const {
    const Mesh& mesh = scene_.meshes[scene_.instances[instances.front()].mesh];
    std::vector<glm::uvec3> triangles;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (std::ranges::any_of(instances, [&](std::uint32_t i) { return kept_[i][t] != 0; }))
            triangles.push_back(mesh.triangles[t]);
    return triangles;
}

void ModelDraft::build_placed(SceneModel& out) {
    std::vector<std::uint32_t> instances;
    for (std::uint32_t i = 0; i < part_.size(); ++i)
        if (part_[i] == Part::placed && std::ranges::count(kept_[i], 0) != std::ptrdiff_t(kept_[i].size()))
            instances.push_back(i);
    std::vector<int> allowed(instances.size());
    tbb::parallel_for(std::size_t{0}, instances.size(),
                      [&](std::size_t i) { allowed[i] = allowed_log4(instances[i]); });
    std::map<std::pair<std::uint32_t, int>, std::vector<std::uint32_t>> versions;
    for (std::size_t i = 0; i < instances.size(); ++i)
        versions[{scene_.instances[instances[i]].mesh, allowed[i]}].push_back(instances[i]);
    std::vector<std::pair<std::pair<std::uint32_t, int>, std::vector<std::uint32_t>>> list(versions.begin(),
                                                                                           versions.end());
    std::vector<Mesh> meshes(list.size());
    tbb::parallel_for(std::size_t{0}, list.size(), [&](std::size_t i) {
        const auto& [key, users] = list[i];
        Mesh mesh = part_of(scene_.meshes[key.first], kept_of_mesh(users));
        if (key.second != exact_log4) {
            Mesh welded = mesh;
            const std::vector<std::uint32_t> point = weld(mesh.positions);
            for (std::size_t v = 0; v < point.size(); ++v)
                welded.positions[point[v]] = mesh.positions[v];
            for (glm::uvec3& t : welded.triangles)
                t = {point[t.x], point[t.y], point[t.z]};
            mesh = part_of(welded, simplified(welded.positions, welded.triangles, std::ldexp(1.0, 2 * key.second)));
        }
        meshes[i] = std::move(mesh);
    });
    for (std::size_t i = 0; i < list.size(); ++i) {
        if (meshes[i].triangles.empty())
            continue;
        meshes[i].material = 0;
        meshes[i].uvs.clear();
        out.meshes.push_back(std::move(meshes[i]));
        for (const std::uint32_t instance : list[i].second)
            place(out, std::uint32_t(out.meshes.size() - 1), instance);
    }
}

void ModelDraft::build_exact(SceneModel& out) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> users;
    for (std::uint32_t i = 0; i < part_.size(); ++i)
        if (part_[i] == Part::exact && std::ranges::count(kept_[i], 0) != std::ptrdiff_t(kept_[i].size()))
            users[scene_.instances[i].mesh].push_back(i);
    for (const auto& [mesh_index, instances] : users) {
        const Mesh& mesh = scene_.meshes[mesh_index];
        Mesh part = part_of(mesh, kept_of_mesh(instances));
        part.material = material_of(out, mesh);
        if (part.material == 0)
            part.uvs.clear();
        out.meshes.push_back(std::move(part));
        for (const std::uint32_t instance : instances)
            place(out, std::uint32_t(out.meshes.size() - 1), instance);
    }
}

/// Movers keep their node, so that they can move; the others get one of their own.
void ModelDraft::place(SceneModel& out, std::uint32_t mesh, std::uint32_t instance) {
    const Instance& from = scene_.instances[instance];
    std::uint32_t object = moving_[instance] ? new_object_[from.object] : no_index;
    if (object == no_index) {
        object = std::uint32_t(out.objects.size());
        out.objects.push_back({own_name, -1, from.world_from_object});
    }
    out.instances.push_back({mesh, object, from.world_from_object});
    source_instance_.push_back(instance);
}

std::uint32_t ModelDraft::material_of(SceneModel& out, const Mesh& mesh) {
    const std::uint32_t mask = scene_.mask_of(mesh);
    if (mask == no_index)
        return 0;
    std::uint32_t& material = new_material_[mesh.material];
    if (material == no_index) {
        material = std::uint32_t(out.materials.size());
        Material masked;
        masked.name = scene_.materials[mesh.material].name;
        masked.alpha_mask = std::uint32_t(out.alpha_masks.size());
        masked.base_colour_texture = std::uint32_t(out.textures.size());
        masked.double_sided = true;
        out.alpha_masks.push_back(scene_.alpha_masks[mask]);
        out.textures.push_back(mask_texture(scene_.alpha_masks[mask], masked.name));
        out.materials.push_back(std::move(masked));
    }
    return material;
}

void ModelDraft::restore_scene_side(const HitId& hit) {
    if (hit.instance == no_index)
        return;
    kept_[hit.instance][hit.triangle] = 1;
    const Mesh& mesh = scene_.meshes[scene_.instances[hit.instance].mesh];
    if (part_[hit.instance] == Part::placed)
        tighten(strictness_[hit.instance]);
    if (part_[hit.instance] == Part::merged)
        for (int corner = 0; corner < 3; ++corner)
            tighten(merged_.strictness[points_[first_vertex_[hit.instance] + mesh.triangles[hit.triangle][corner]]]);
}

void ModelDraft::restore_model_side(const HitId& hit) {
    if (hit.instance == no_index)
        return;
    const std::uint32_t source = source_instance_[hit.instance];
    if (source == no_index)
        for (int corner = 0; corner < 3; ++corner)
            tighten(merged_.strictness[merged_triangles_[hit.triangle][corner]]);
    else if (part_[source] == Part::placed)
        tighten(strictness_[source]);
}

void ModelDraft::restore(const std::vector<FailedRay>& failed) {
    for (const FailedRay& ray : failed) {
        restore_scene_side(ray.scene);
        restore_model_side(ray.model);
    }
}

}  // namespace equistream
