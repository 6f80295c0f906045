#include "bsdf.h"

#include "directions.h"
#include "sampler.h"

#include <scenes/library/model.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace equistream::embree_host {
float dielectric_f0(float index_of_refraction) {
    const float r = (index_of_refraction - 1) / (index_of_refraction + 1);
    return r * r;
}

namespace {

/// Reflectance at grazing incidence: 1, but fading out where the index of refraction approaches 1 and there is hardly a
/// surface to reflect (at 1.33 and above it is 1).
float grazing(float f0) {
    return std::min(1.0f, 50 * f0);
}

/// Energy that a smooth dielectric lets below its surface.
float entering(float f0, float cosine) {
    const float w = schlick_weight(cosine);
    return 1 - f0 * (1 - w) - grazing(f0) * w;
}

constexpr int table_side = 32;
using AlbedoTable = std::array<std::array<GgxAlbedo, table_side>, table_side>;  // [sqrt alpha][cosine]

GgxAlbedo integrate_albedo(float cosine, float alpha) {
    constexpr std::uint32_t points = 256;
    const glm::vec3 viewer{std::sqrt(std::max(0.0f, 1 - cosine * cosine)), 0, cosine};
    const float lambda_viewer = ggx_lambda(viewer, alpha);
    double scale = 0, bias = 0;
    for (std::uint32_t i = 0; i < points; ++i) {
        const glm::vec2 u{(static_cast<float>(i) + 0.5f) / static_cast<float>(points), unit_float(reverse_bits(i))};
        const glm::vec3 half = ggx_sample_visible_normal(viewer, alpha, u);
        const float viewer_half = glm::dot(viewer, half);
        const glm::vec3 light = 2 * viewer_half * half - viewer;
        if (light.z <= 0)
            continue;
        const double weight = (1 + lambda_viewer) / (1 + lambda_viewer + ggx_lambda(light, alpha));
        const double fresnel = schlick_weight(viewer_half);
        scale += weight * (1 - fresnel);
        bias += weight * fresnel;
    }
    return {static_cast<float>(scale / points), static_cast<float>(bias / points)};
}

AlbedoTable make_table() {
    AlbedoTable table;
    for (int a = 0; a < table_side; ++a) {
        const float root = std::max(0.01f, static_cast<float>(a) / (table_side - 1));
        for (int c = 0; c < table_side; ++c) {
            const float cosine = std::max(0.002f, static_cast<float>(c) / (table_side - 1));
            table[a][c] = integrate_albedo(cosine, root * root);
        }
    }
    return table;
}

GgxAlbedo mix(const GgxAlbedo& a, const GgxAlbedo& b, float t) {
    return {a.scale + t * (b.scale - a.scale), a.bias + t * (b.bias - a.bias)};
}

}  // namespace

float pane_reflectance(float f0, float cosine) {
    if (f0 <= 0)
        return 0;
    const float index = (1 + std::sqrt(f0)) / (1 - std::sqrt(f0));
    const float refracted = std::sqrt(1 - (1 - cosine * cosine) / (index * index));
    const float across = (cosine - index * refracted) / (cosine + index * refracted);
    const float along = (index * cosine - refracted) / (index * cosine + refracted);
    const float side = 0.5f * (across * across + along * along);
    return 2 * side / (1 + side);
}

glm::vec3 straight_transmittance(const SurfaceParameters& p, float cosine) {
    return p.base_colour * ((1 - p.metallic) * (1 - pane_reflectance(p.dielectric_f0, cosine)) * p.transmission);
}

Bsdf::Bsdf(const SurfaceParameters& p, float cos_viewer, float alpha_floor) {
    const float dielectric = 1 - p.metallic;
    f0_ = glm::vec3(dielectric * p.dielectric_f0) + p.metallic * p.base_colour;
    f90_ = dielectric * grazing(p.dielectric_f0) + p.metallic;
    const bool glass = p.transmission > 0, smooth = p.roughness < mirror_roughness;
    alpha_ = glass ? 0 : std::max(smooth ? 0 : p.roughness * p.roughness, alpha_floor);

    glm::vec3 specular_albedo;
    float below;  // share of light that reaches the dielectric's inside
    if (glass) {
        const float pane = pane_reflectance(p.dielectric_f0, cos_viewer);
        const glm::vec3 metal = p.base_colour + (1.0f - p.base_colour) * schlick_weight(cos_viewer);
        specular_albedo = glm::vec3(dielectric * pane) + p.metallic * metal;
        below = 1 - pane;
    } else if (alpha_ == 0) {
        specular_albedo = fresnel(cos_viewer);
        below = entering(p.dielectric_f0, cos_viewer);
    } else {
        const GgxAlbedo lobe = ggx_albedo(cos_viewer, alpha_);
        const float lost = (1 - lobe.white()) / lobe.white();
        specular_scale_ = 1.0f + f0_ * lost;
        specular_albedo = (f0_ * lobe.scale + f90_ * lobe.bias) * specular_scale_;
        const float f90 = grazing(p.dielectric_f0);
        below = std::max(0.0f, 1 - (p.dielectric_f0 * lobe.scale + f90 * lobe.bias) * (1 + p.dielectric_f0 * lost));
    }
    diffuse_ = p.base_colour * (dielectric * below * (1 - p.transmission));
    straight_ = glass ? straight_transmittance(p, cos_viewer) : glm::vec3(0);
    mirrored_ = specular_albedo;
    choose_probabilities(specular_albedo);
}

void Bsdf::choose_probabilities(const glm::vec3& specular_albedo) {
    const float s = luminance(specular_albedo), d = luminance(diffuse_), t = luminance(straight_);
    const float sum = s + d + t;
    if (!(sum > 0))
        return;
    p_specular_ = s / sum;
    p_diffuse_ = d / sum;
    p_straight_ = t / sum;
}

glm::vec3 Bsdf::fresnel(float cosine) const {
    return f0_ + (f90_ - f0_) * schlick_weight(cosine);
}

BsdfValue Bsdf::evaluate(const glm::vec3& viewer, const glm::vec3& light) const {
    if (light.z <= 0 || viewer.z <= 0)
        return {};
    const float cosine_pdf = light.z / pi_f;
    BsdfValue result{diffuse_ * cosine_pdf, p_diffuse_ * cosine_pdf};
    if (alpha_ == 0 || p_specular_ == 0)
        return result;
    const glm::vec3 half = glm::normalize(viewer + light);
    const float d = ggx_distribution(half, alpha_) / (4 * viewer.z);
    const float lambda_viewer = ggx_lambda(viewer, alpha_);
    const float shadowing = 1 / (1 + lambda_viewer + ggx_lambda(light, alpha_));
    result.value += fresnel(glm::dot(viewer, half)) * specular_scale_ * (d * shadowing);
    result.pdf += p_specular_ * d / (1 + lambda_viewer);
    return result;
}

BsdfSample Bsdf::sample_specular(const glm::vec3& viewer, const glm::vec2& u) const {
    BsdfSample s;
    if (alpha_ == 0) {
        s.direction = {-viewer.x, -viewer.y, viewer.z};
        s.weight = mirrored_ / p_specular_;
        s.kind = BsdfSample::Kind::mirror;
        return s;
    }
    const glm::vec3 half = ggx_sample_visible_normal(viewer, alpha_, u);
    s.direction = 2 * glm::dot(viewer, half) * half - viewer;
    s.kind = s.direction.z > 0 ? BsdfSample::Kind::rough : BsdfSample::Kind::none;
    return s;
}

BsdfSample Bsdf::sample(const glm::vec3& viewer, float lobe, const glm::vec2& u) const {
    BsdfSample s;
    if (lobe < p_diffuse_) {
        s.direction = sample_cosine_hemisphere(u);
        s.kind = s.direction.z > 0 ? BsdfSample::Kind::rough : BsdfSample::Kind::none;
    } else if (lobe < p_diffuse_ + p_straight_) {
        s.direction = -viewer;
        s.weight = straight_ / p_straight_;
        s.kind = BsdfSample::Kind::straight;
    } else if (p_specular_ > 0) {
        s = sample_specular(viewer, u);
    }
    if (s.kind != BsdfSample::Kind::rough)
        return s;
    const BsdfValue both = evaluate(viewer, s.direction);
    s.pdf = both.pdf;
    s.weight = both.pdf > 0 ? both.value / both.pdf : glm::vec3(0);
    return s;
}

float ggx_distribution(const glm::vec3& half, float alpha) {
    // x^2 + y^2 rather than 1 - z^2: no cancellation for sharp lobes.
    const float a2 = alpha * alpha;
    const float d = half.x * half.x + half.y * half.y + a2 * half.z * half.z;
    return a2 / (pi_f * d * d);
}

float ggx_lambda(const glm::vec3& w, float alpha) {
    const float tan2 = (w.x * w.x + w.y * w.y) / std::max(w.z * w.z, 1e-12f);
    return 0.5f * (std::sqrt(1 + alpha * alpha * tan2) - 1);
}

glm::vec3 ggx_sample_visible_normal(const glm::vec3& viewer, float alpha, const glm::vec2& u) {
    const glm::vec3 stretched = glm::normalize(glm::vec3(viewer.x * alpha, viewer.y * alpha, viewer.z));
    const float phi = 2 * pi_f * u.x;
    const float z = (1 - u.y) * (1 + stretched.z) - stretched.z;
    const float sine = std::sqrt(std::clamp(1 - z * z, 0.0f, 1.0f));
    const glm::vec3 half = glm::vec3(sine * std::cos(phi), sine * std::sin(phi), z) + stretched;
    return glm::normalize(glm::vec3(half.x * alpha, half.y * alpha, std::max(half.z, 1e-6f)));
}

GgxAlbedo ggx_albedo(float cosine, float alpha) {
    static const AlbedoTable table = make_table();
    const float a = std::clamp(std::sqrt(alpha), 0.0f, 1.0f) * (table_side - 1);
    const float c = std::clamp(cosine, 0.0f, 1.0f) * (table_side - 1);
    const int a0 = std::min(static_cast<int>(a), table_side - 2);
    const int c0 = std::min(static_cast<int>(c), table_side - 2);
    const float ct = c - static_cast<float>(c0);
    return mix(mix(table[a0][c0], table[a0][c0 + 1], ct), mix(table[a0 + 1][c0], table[a0 + 1][c0 + 1], ct),
               a - static_cast<float>(a0));
}

}  // namespace equistream::embree_host
