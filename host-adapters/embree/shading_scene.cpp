#include "shading_scene.h"

#include <equistream/virtual_image.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace equistream::embree_host {
namespace {

ShadingMaterial shading_material(const Material& m) {
    ShadingMaterial s{};
    s.base_colour = m.base_colour;
    s.base_colour_texture = m.base_colour_texture;
    s.emission = m.emission;
    s.emission_texture = m.emission_texture;
    s.metallic = m.metallic;
    s.roughness = m.roughness;
    s.transmission = m.transmission;
    s.dielectric_f0 = dielectric_f0(m.index_of_refraction);
    s.metallic_roughness_texture = m.metallic_roughness_texture;
    s.emits = !is_black(m.emission);
    s.double_sided = m.double_sided;
    s.thin_glass = m.transmission > 0;
    return s;
}

glm::vec3 facing(const glm::vec3& n, const glm::vec3& towards) {
    return glm::dot(n, towards) < 0 ? -n : n;
}

glm::vec3 guarded_normal(const glm::vec3& n, const glm::vec3& geometric, const glm::vec3& viewer) {
    const auto v =
        visible_normal<float>({n.x, n.y, n.z}, {geometric.x, geometric.y, geometric.z}, {viewer.x, viewer.y, viewer.z});
    return {v.x, v.y, v.z};
}

}  // namespace

ShadingScene::ShadingScene(const SceneModel& model)
    : model_(model), triangles_(model.meshes.size()), instances_(model.instances.size()),
      linear_(model.instances.size()) {
    for (const Material& material : model.materials) {
        materials_.push_back(shading_material(material));
        has_thin_glass_ = has_thin_glass_ || materials_.back().thin_glass;
    }
    tbb::parallel_for(std::size_t{0}, triangles_.size(), [&](std::size_t i) { pack(model.meshes[i], triangles_[i]); });
    std::vector<glm::mat4> transforms(model.instances.size());
    for (std::size_t i = 0; i < transforms.size(); ++i)
        transforms[i] = model.instances[i].world_from_object;
    place_instances(transforms);
}

void ShadingScene::pack(const Mesh& mesh, std::vector<TriangleRecord>& records) const {
    records.resize(mesh.triangles.size());
    for (std::size_t i = 0; i < records.size(); ++i) {
        const glm::uvec3 t = mesh.triangles[i];
        TriangleRecord& r = records[i];
        const glm::vec3 ab = mesh.positions[t.y] - mesh.positions[t.x], ac = mesh.positions[t.z] - mesh.positions[t.x];
        const glm::vec3 across = glm::cross(ab, ac);
        r = {};
        r.geometric_normal = pack_direction(across);
        for (int corner = 0; corner < 3 && !mesh.normals.empty(); ++corner) {
            const glm::vec3& normal = mesh.normals[t[corner]];
            r.normals[corner] = pack_direction(glm::dot(normal, normal) > 0 ? normal : across);
        }
        for (int corner = 0; corner < 3 && !mesh.uvs.empty(); ++corner)
            r.uvs[corner] = mesh.uvs[t[corner]];
        const glm::vec2 uv_ab = r.uvs[1] - r.uvs[0], uv_ac = r.uvs[2] - r.uvs[0];
        const float uv_area = std::abs(uv_ab.x * uv_ac.y - uv_ab.y * uv_ac.x), area = glm::length(across);
        r.uv_per_metre = area > 0 ? std::sqrt(uv_area / area) : 0;
    }
}

void ShadingScene::place_instances(std::span<const glm::mat4> world_from_object) {
    for (std::size_t i = 0; i < instances_.size(); ++i) {
        const Instance& instance = model_.instances[i];
        const Mesh& mesh = model_.meshes[instance.mesh];
        const glm::mat3 m(world_from_object[i]);
        const float volume = glm::determinant(m);
        const float scale = std::cbrt(std::abs(volume));
        InstanceRecord& r = instances_[i];
        // A flattened instance has no inverse; the cofactors are the inverse transpose up to a factor all the same.
        const glm::mat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
        const float size = std::max({glm::length(cofactors[0]), glm::length(cofactors[1]), glm::length(cofactors[2])});
        r.normal_from_object = size > 0 ? cofactors / size : glm::mat3(1);
        linear_[i] = m;
        r.triangles = triangles_[instance.mesh].data();
        r.material =
            mesh.material < materials_.size() ? mesh.material : static_cast<std::uint32_t>(materials_.size() - 1);
        r.objects_per_metre = scale > 0 ? 1 / scale : 1;
        r.mirrored = volume < 0;
        r.smooth = !mesh.normals.empty();
    }
}

ShadingPoint ShadingScene::surface_at(const HitId& hit, const glm::vec3& origin, const glm::vec3& direction,
                                      float distance) const {
    const InstanceRecord& instance = instances_[hit.instance];
    const TriangleRecord& t = instance.triangles[hit.triangle];
    const float w = 1 - hit.u - hit.v;
    ShadingPoint p;
    p.position = origin + distance * direction;
    p.reach = distance;
    const glm::vec3 wound = glm::normalize(instance.normal_from_object * unpack_direction(t.geometric_normal));
    p.geometric_normal = facing(wound, -direction);
    // glTF: a mirroring transform reverses the winding that faces the front.
    p.front = (glm::dot(wound, direction) < 0) != instance.mirrored;
    p.normal = p.geometric_normal;
    if (instance.smooth) {
        const glm::vec3 n = w * unpack_direction(t.normals[0]) + hit.u * unpack_direction(t.normals[1]) +
                            hit.v * unpack_direction(t.normals[2]);
        p.normal = guarded_normal(instance.normal_from_object * n, p.geometric_normal, -direction);
    }
    p.uv = w * t.uvs[0] + hit.u * t.uvs[1] + hit.v * t.uvs[2];
    p.uv_per_metre = t.uv_per_metre * instance.objects_per_metre;
    p.material = instance.material;
    return p;
}

glm::vec3 ShadingScene::normal_change(const HitId& hit, const ShadingPoint& at, const glm::vec3& movement) const {
    const InstanceRecord& instance = instances_[hit.instance];
    if (!instance.smooth)
        return glm::vec3(0);
    const Mesh& mesh = model_.meshes[model_.instances[hit.instance].mesh];
    const glm::uvec3 t = mesh.triangles[hit.triangle];
    const glm::mat3& world = linear_[hit.instance];
    const glm::vec3 ab = world * (mesh.positions[t.y] - mesh.positions[t.x]);
    const glm::vec3 ac = world * (mesh.positions[t.z] - mesh.positions[t.x]);
    const float bb = glm::dot(ab, ab), bc = glm::dot(ab, ac), cc = glm::dot(ac, ac);
    const float determinant = bb * cc - bc * bc;
    if (!(determinant > 0))
        return glm::vec3(0);
    const float mb = glm::dot(movement, ab), mc = glm::dot(movement, ac);
    const float along_ab = (cc * mb - bc * mc) / determinant, along_ac = (bb * mc - bc * mb) / determinant;
    const glm::vec3 &na = mesh.normals[t.x], &nb = mesh.normals[t.y], &nc = mesh.normals[t.z];
    const glm::vec3 n = instance.normal_from_object * ((1 - hit.u - hit.v) * na + hit.u * nb + hit.v * nc);
    const glm::vec3 change = instance.normal_from_object * (along_ab * (nb - na) + along_ac * (nc - na));
    const float length = glm::length(n);
    if (!(length > 0))
        return glm::vec3(0);
    // Facing the viewer, as the normal itself does.
    const float sign = glm::dot(n, at.normal) < 0 ? -1.0f : 1.0f;
    return sign / length * (change - n * (glm::dot(n, change) / (length * length)));
}

SurfaceParameters surface_parameters(const ShadingMaterial& m, const ShadingPoint& point, float footprint_m,
                                     const glm::vec3& jitter, Textures::Reader& textures) {
    SurfaceParameters s{m.base_colour, m.metallic, m.roughness, m.transmission, m.dielectric_f0};
    TextureQuery query{point.uv, footprint_m * point.uv_per_metre, jitter};
    if (m.base_colour_texture != no_index)
        s.base_colour *= textures.lookup(m.base_colour_texture, query);
    if (m.metallic_roughness_texture != no_index) {
        query.coding = TextureCoding::data;
        const glm::vec3 texel = textures.lookup(m.metallic_roughness_texture, query);
        s.roughness *= texel.y;
        s.metallic *= texel.z;
    }
    return s;
}

glm::vec3 emitted_radiance(const ShadingMaterial& m, const ShadingPoint& point, float footprint_m,
                           const glm::vec3& jitter, Textures::Reader& textures) {
    if (!m.emits || (!point.front && !m.double_sided))
        return glm::vec3(0);
    if (m.emission_texture == no_index)
        return m.emission;
    return m.emission * textures.lookup(m.emission_texture, {point.uv, footprint_m * point.uv_per_metre, jitter});
}

}  // namespace equistream::embree_host
