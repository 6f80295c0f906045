#pragma once
/// How a surface scatters light: glTF's metallic-roughness model plus thin glass.
///
///   specular   GGX with height-correlated Smith shadowing and Schlick's Fresnel, sampled by visible normals; below
///              mirror_roughness (model.h) a perfect mirror. Scaled by 1 + F0 (1 - E) / E (E: albedo of the
///              white lobe) for the light that single scattering loses (Turquin 2019), so that a white metal reflects
///              everything.
///   diffuse    Lambert, scaled by 1 - albedo of the dielectric specular lobe towards the viewer. The sum never
///              exceeds 1 and is 1 for white. Albedo scaling is not reciprocal; a unidirectional tracer can afford it.
///   glass      KHR_materials_transmission without a volume is thin-walled: light goes straight on, tinted by the base
///              colour, through a pane with two sides that reflect by Fresnel's equations and between each other (where
///              glTF suggests one side and Schlick's curve). All real scenes' glass is smooth: transmission is never
///              rough.
///
/// Directions are local: +Z is the shading normal, on the viewer's side. Values are plain; everything is thread-safe.
#include <equistream/virtual_image.h>

#include <glm/glm.hpp>

namespace equistream::embree_host {

/// What texture lookups leave of a material at one point.
struct SurfaceParameters {
    glm::vec3 base_colour{1};
    float metallic = 0;
    float roughness = 1;
    float transmission = 0;
    float dielectric_f0 = 0.04f;
};

struct BsdfValue {
    glm::vec3 value{0};  ///< BSDF times cosine
    float pdf = 0;       ///< with which sample() would have chosen this direction, lobes mixed
};

struct BsdfSample {
    enum class Kind { none, rough, mirror, straight };
    glm::vec3 direction{0};
    glm::vec3 weight{0};  ///< value / pdf
    float pdf = 0;        ///< of a rough sample only
    Kind kind = Kind::none;
};

/// What the AOV "specular" takes for a mirror.
inline constexpr float sharp_alpha = 0.05f;

class Bsdf {
public:
    /// `cos_viewer` > 0 is the cosine between shading normal and viewer. Specular lobes sharper than `alpha_floor` are
    /// widened to it, mirrors too, glass not (path_tracer.h says why).
    Bsdf(const SurfaceParameters& parameters, float cos_viewer, float alpha_floor = 0);

    /// Value and density of the lobes that are not deltas, for both directions on the +Z side.
    BsdfValue evaluate(const glm::vec3& viewer, const glm::vec3& light) const;
    /// One direction; `lobe` chooses between lobes, `u` within one.
    BsdfSample sample(const glm::vec3& viewer, float lobe, const glm::vec2& u) const;

    /// Whether more than min_sharp_share of what is sent to the viewer comes out of sharp lobes: mirror, straight
    /// on, or GGX of an alpha up to sharp_alpha.
    bool is_sharp() const { return p_straight_ + sharp_mirror() > min_sharp_share; }
    /// Of these the one that sends the most: mirror (a narrow GGX lobe too) or straight; none where is_sharp() is not.
    BsdfSample::Kind sharp_lobe() const {
        if (!is_sharp())
            return BsdfSample::Kind::none;
        return sharp_mirror() > p_straight_ ? BsdfSample::Kind::mirror : BsdfSample::Kind::straight;
    }

    /// Whether light arriving from elsewhere than a mirror direction scatters to the viewer at all.
    bool has_rough_lobe() const { return p_diffuse_ > 0 || (p_specular_ > 0 && alpha_ > 0); }

private:
    float sharp_mirror() const { return alpha_ <= sharp_alpha ? p_specular_ : 0; }
    void choose_probabilities(const glm::vec3& specular_albedo);
    glm::vec3 fresnel(float cosine) const;
    BsdfSample sample_specular(const glm::vec3& viewer, const glm::vec2& u) const;

    glm::vec3 diffuse_{0};  // albedo left to the diffuse lobe
    glm::vec3 f0_{0};
    float f90_ = 1;
    glm::vec3 specular_scale_{1};  // multiple scattering
    glm::vec3 straight_{0};
    glm::vec3 mirrored_{0};  // towards cos_viewer, where alpha_ is 0
    float alpha_ = 0;        // 0: mirror
    float p_diffuse_ = 0, p_specular_ = 0, p_straight_ = 0;
};

/// Unpolarised reflectance of a thin pane in air, reflections between its sides included: 2 R / (1 + R) with R of one
/// side by Fresnel's equations. `f0` is one side's at normal incidence, below 1; `cosine` above 0.
float pane_reflectance(float f0, float cosine);

/// What thin glass lets straight through at this cosine between its shading normal and the ray.
glm::vec3 straight_transmittance(const SurfaceParameters& parameters, float cosine);

/// F0 of a dielectric in air.
float dielectric_f0(float index_of_refraction);

// The GGX microfacet distribution, local frame, +Z the normal; alpha = roughness squared. Pure functions.

/// (1 - cos)^5 of Schlick's Fresnel.
inline float schlick_weight(float cosine) {
    const float m = cosine < 1 ? 1 - cosine : 0.0f;
    const float m2 = m * m;
    return m2 * m2 * m;
}

/// Density of normals per solid angle, weighted by cosine it integrates to 1.
float ggx_distribution(const glm::vec3& half, float alpha);
/// Smith's Lambda.
float ggx_lambda(const glm::vec3& w, float alpha);
/// A normal visible from `viewer` (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023).
glm::vec3 ggx_sample_visible_normal(const glm::vec3& viewer, float alpha, const glm::vec2& u);

/// Directional albedo of the single-scattering lobe with Schlick's Fresnel: F0 * scale + F90 * bias.
struct GgxAlbedo {
    float scale = 0;
    float bias = 0;
    float white() const { return scale + bias; }
};
/// From a table integrated at start-up (256 points a cell).
GgxAlbedo ggx_albedo(float cosine, float alpha);

}  // namespace equistream::embree_host
