#pragma once
/// A lat-long image as a light infinitely far away (docs/scenes.md: mapping, rotation).
///
/// As light it is constant over a pixel: light samples choose a pixel in proportion to its luminance times its solid
/// angle and a direction uniformly in it, and radiance() and pdf() are those of the pixel that holds a direction, so
/// that both ways of multiple importance sampling see the same function. What is looked at (by camera rays and mirrors)
/// is filtered like a texture: one texel, chosen by a random offset of half a texel and half a MIP level.
///
/// Immutable once made; any number of threads may read.
#include "directions.h"
#include "shading_scene.h"

#include <equistream/conventions.h>
#include <equistream/image.h>

#include <glm/glm.hpp>

#include <optional>
#include <span>
#include <vector>

namespace equistream::embree_host {

struct SkySample {
    glm::vec3 direction;  ///< unit, world
    glm::vec3 radiance;
    float pdf;  ///< per steradian; above 0
};

class SkyLight {
public:
    /// `image` is RGB: linear radiance, finite and not negative. World = R_y(rotation_rad) image; `scale` is a factor
    /// on radiance.
    SkyLight(FloatImage image, double rotation_rad, const glm::vec3& scale);

    /// Nothing to sample: pdf() is 0 everywhere and sample() may not be called.
    bool is_black() const { return black_; }

    /// Of the pixel that holds a unit direction.
    glm::vec3 radiance(const glm::vec3& direction) const;
    float pdf(const glm::vec3& direction) const;
    SkySample sample(const glm::vec2& u) const;

    /// What a cone `spread_rad` wide sees; `jitter` three numbers in [0, 1).
    glm::vec3 filtered(const glm::vec3& direction, float spread_rad, const glm::vec3& jitter) const;

private:
    struct Pixel {
        int x, y;
    };
    Vector3<float> to_image(const glm::vec3& direction) const;
    Pixel pixel_at(const glm::vec3& direction) const;
    float pixel_pdf(const Pixel& pixel) const;
    std::span<const float> row_steps(int y) const;
    void build_distribution();

    std::vector<FloatImage> levels_;  // each half as large, weighted by solid angle
    float cos_rotation_, sin_rotation_;
    bool black_ = true;
    std::vector<float> steps_of_rows_;     // height + 1: shares of power above each row
    std::vector<float> steps_in_rows_;     // height x (width + 1): shares of a row's power left of each pixel
    std::vector<float> inverse_pixel_sr_;  // by row: 1 / solid angle of a pixel
    std::vector<double> row_sines_;        // height + 1: sine of the latitude of each row's upper edge
};

// What lights a scene: a sun (a small uniform disc), a sky (constant, or an image), emissive triangles.
//
// Sampling: the sun by its cone; emissive triangles in proportion to mean power (area times the luminance of the
// material's mean emission), one triangle and one point on it. A point that an alpha mask has cut away is a sample
// without light, so that the density is the same all over a triangle. A sky that is an image by its pixels
// (lights.h). The constant sky is left to BSDF sampling alone: under it that has no variance but that of
// visibility, and the ray has to be traced for indirect light anyway. Where little of it is visible, light samples go
// through the openings that it is seen through (sky_openings.h), of either sky.

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
    /// So many that a float's 24 bits are too few for both steps of a choice: `choice` needs those below them.
    bool are_many() const { return triangles_.size() > 4096; }
    EmitterSample sample(double choice, const glm::vec2& u) const;

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

    /// The sky as light samples take it; SkyLight::filtered is what is looked at.
    glm::vec3 sampled_sky(const glm::vec3& direction) const {
        return sky_image ? sky + sky_image->radiance(direction) : sky;
    }
};

}  // namespace equistream::embree_host
