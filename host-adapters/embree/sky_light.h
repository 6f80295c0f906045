#pragma once
/// A lat-long image as a light infinitely far away (docs/scenes.md: mapping, rotation).
///
/// As light it is constant over a pixel: light samples choose a pixel in proportion to its luminance times its solid
/// angle and a direction uniformly in it, and radiance() and pdf() are those of the pixel that holds a direction, so
/// that both ways of multiple importance sampling see the same function. What is looked at (by camera rays and mirrors)
/// is filtered like a texture: one texel, chosen by a random offset of half a texel and half a MIP level.
///
/// Immutable once made; any number of threads may read.
#include <equistream/conventions.h>
#include <equistream/image.h>

#include <glm/glm.hpp>

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

}  // namespace equistream::embree_host
