#include "ggx.h"

#include "directions.h"
#include "sampler.h"

#include <algorithm>
#include <array>

namespace equistream::embree_host {
namespace {

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

float ggx_reflection_pdf(const glm::vec3& viewer, const glm::vec3& half, float alpha) {
    return ggx_distribution(half, alpha) / ((1 + ggx_lambda(viewer, alpha)) * 4 * viewer.z);
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
