#pragma once
/// What lights a scene: a sun (a small uniform disc), a sky (constant, or an image), emissive triangles.
///
/// Sampling: the sun by its cone; emissive triangles in proportion to mean power (area times the luminance of the
/// material's mean emission), one triangle and one point on it. A point that an alpha mask has cut away is a sample
/// without light, so that the density is the same all over a triangle. A sky that is an image by its pixels
/// (sky_light.h). The constant sky is left to BSDF sampling alone: under it that has no variance but that of
/// visibility, and the ray has to be traced for indirect light anyway.
#include "directions.h"
#include "shading_scene.h"
#include "sky_light.h"

#include <optional>
#include <span>
#include <vector>

namespace equistream::embree_host {

struct SunLight {
    glm::vec3 towards;   ///< unit
    ShadingFrame frame;  ///< around `towards`
    glm::vec3 radiance{0};
    float one_minus_cos = 0;  ///< of the angular radius
    float pdf = 0;            ///< 1 / solid angle

    /// `irradiance` on a plane facing it. Radii below 0.0002 rad (a 23rd of the sun's) are raised to that.
    SunLight(const glm::vec3& direction, const glm::vec3& irradiance, float angular_radius_rad);

    bool contains(const glm::vec3& direction) const {
        // |a - b|^2 = 2 (1 - cos): no cancellation at small angles.
        const glm::vec3 apart = direction - towards;
        return glm::dot(apart, apart) < 2 * one_minus_cos;
    }
};

/// A point on an emissive triangle.
struct EmitterSample {
    glm::vec3 position;
    glm::vec3 normal;  ///< unit, of the front
    glm::vec2 uv;
    std::uint32_t material;  ///< whose emission_pdf_area is the density of `position` per square metre
    bool cut_away;           ///< by the material's alpha mask: no light comes from here, as no ray is stopped here
};

/// Emissive triangles behind an alias table.
class EmitterTable {
public:
    /// Reads instances as they stand at this frame; writes each material's emission_pdf_area.
    void build(ShadingScene& scene, std::span<const glm::mat4> world_from_object, const Textures& textures);
    bool empty() const { return triangles_.empty(); }
    EmitterSample sample(float choice, const glm::vec2& u) const;

private:
    struct Triangle {
        glm::vec3 a, ab, ac;
        glm::vec2 uv_a{0}, uv_ab{0}, uv_ac{0};
        const AlphaMask* mask;  // nullptr: whole
        std::uint32_t material;
        float area;
        bool mirrored;
    };
    void add_instance(const ShadingScene& scene, std::uint32_t index, const glm::mat4& world_from_object);
    void build_alias_table(const std::vector<double>& powers, double total);

    std::vector<Triangle> triangles_;
    std::vector<float> keep_;  // alias method: keep i with this probability, else take alias_[i]
    std::vector<std::uint32_t> alias_;
};

struct Lights {
    std::optional<SunLight> sun;
    glm::vec3 sky{0};  ///< constant, added to the image's
    std::optional<SkyLight> sky_image;
    EmitterTable emitters;
};

}  // namespace equistream::embree_host
