#pragma once
/// A SceneModel packed for shading: what one hit needs lies in three cache lines (instance, triangle, material).
/// Immutable while rays are traced; place_instances between frames.
#include "bsdf.h"
#include "directions.h"
#include "textures.h"

#include <scenes/embree/bvh.h>

#include <span>
#include <vector>

namespace equistream::embree_host {

/// A point on a surface, ready to scatter. Vectors are in world space and unit.
struct ShadingPoint {
    glm::vec3 position;
    glm::vec3 geometric_normal;  ///< on the viewer's side
    glm::vec3 normal;            ///< shading normal on the viewer's side, visible from it
    glm::vec2 uv{0};
    float uv_per_metre = 0;  ///< texture coordinates per metre on the surface
    std::uint32_t material = 0;
    float reach = 0;    ///< of the ray that found it
    bool front = true;  ///< seen from the side that counter-clockwise winding faces
};

/// Width of the cone that a ray stands for: at its origin, and how it grows (Akenine-Moeller's ray cones).
struct RayCone {
    float width_m = 0;
    float spread_rad = 0;
};

struct ShadingMaterial {
    glm::vec3 base_colour;
    std::uint32_t base_colour_texture;
    glm::vec3 emission;
    std::uint32_t emission_texture;
    float metallic, roughness, transmission, dielectric_f0;
    std::uint32_t metallic_roughness_texture;
    float emission_pdf_area;  ///< density per square metre with which the light table samples it; set by Lights
    bool emits, double_sided, thin_glass;
};

class ShadingScene {
public:
    explicit ShadingScene(const SceneModel& model);

    /// World transforms of all instances for this frame.
    void place_instances(std::span<const glm::mat4> world_from_object);

    /// Starts loading what surface_at will read.
    void prefetch(const HitId& hit) const {
        const InstanceRecord& instance = instances_[hit.instance];
        __builtin_prefetch(&instance.triangles[hit.triangle]);
    }
    ShadingPoint surface_at(const HitId& hit, const glm::vec3& origin, const glm::vec3& direction,
                            float distance) const;

    /// How the shading normal at a hit changes, to first order, when the point moves within its triangle's plane.
    glm::vec3 normal_change(const HitId& hit, const ShadingPoint& at, const glm::vec3& movement) const;

    const SceneModel& model() const { return model_; }
    const ShadingMaterial& material(std::uint32_t index) const { return materials_[index]; }
    std::span<ShadingMaterial> materials() { return materials_; }
    std::uint32_t material_of(std::uint32_t instance) const { return instances_[instance].material; }
    bool has_thin_glass() const { return has_thin_glass_; }

private:
    struct alignas(64) TriangleRecord {
        PackedDirection normals[3];
        PackedDirection geometric_normal;
        glm::vec2 uvs[3];
        float uv_per_metre;  // in object space
    };
    struct alignas(64) InstanceRecord {
        glm::mat3 normal_from_object;  // inverse transpose, scaled to keep lengths near 1
        const TriangleRecord* triangles;
        std::uint32_t material;
        float objects_per_metre;  // inverse of the transform's mean scale
        bool mirrored;
        bool smooth;  // vertex normals are given
    };

    void pack(const Mesh& mesh, std::vector<TriangleRecord>& records) const;

    const SceneModel& model_;
    std::vector<std::vector<TriangleRecord>> triangles_;  // by mesh
    std::vector<InstanceRecord> instances_;
    std::vector<glm::mat3> linear_;  // of the instances' transforms; normal_change alone needs them
    std::vector<ShadingMaterial> materials_;
    bool has_thin_glass_ = false;
};

/// What the material's textures say at a point. `footprint_m` is the width of what is looked at there.
SurfaceParameters surface_parameters(const ShadingMaterial& material, const ShadingPoint& point, float footprint_m,
                                     const glm::vec3& jitter, Textures::Reader& textures);

/// Radiance emitted towards the viewer.
glm::vec3 emitted_radiance(const ShadingMaterial& material, const ShadingPoint& point, float footprint_m,
                           const glm::vec3& jitter, Textures::Reader& textures);

}  // namespace equistream::embree_host
