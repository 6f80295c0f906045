#pragma once
/// The GGX microfacet distribution, local frame, +Z the normal; alpha = roughness squared. Pure functions.
#include <glm/glm.hpp>

namespace equistream::embree_host {

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
/// Density of the reflected direction that sampling visible normals gives.
float ggx_reflection_pdf(const glm::vec3& viewer, const glm::vec3& half, float alpha);

/// Directional albedo of the single-scattering lobe with Schlick's Fresnel: F0 * scale + F90 * bias.
struct GgxAlbedo {
    float scale = 0;
    float bias = 0;
    float white() const { return scale + bias; }
};
/// From a table integrated at start-up (256 points a cell).
GgxAlbedo ggx_albedo(float cosine, float alpha);

}  // namespace equistream::embree_host
