#pragma once
/// The rays one frame asks its host for.
#include <equistream/equistream.h>
#include <equistream/frame.h>

namespace equistream {

/// Immutable after construction; any number of threads.
class FrameRays {
public:
    explicit FrameRays(const FrameInfo& info);

    /// Through the centre of pixel (x, y).
    es_ray geometry(int x, int y) const;
    /// Jittered within it: colour pass `sample`.
    es_ray colour(int x, int y, std::uint32_t sample) const;

private:
    /// A pixel of the picture, and where in its camera's image (or on its auxiliary sphere) a ray goes through it.
    struct Place {
        int x, y;
        double u, v;
    };
    es_ray ray(const glm::vec3& direction_camera, const Place& place, std::uint32_t sample) const;
    Place place_of(int x, int y, double u, double v) const;
    std::uint32_t pixel_of(int x, int y) const { return static_cast<std::uint32_t>(y * width_ + x); }
    glm::vec3 direction_float(float u, float v) const;
    float footprint_rad(const glm::vec3& direction_camera) const;

    Camera camera_;
    std::optional<PatchAtlas> atlas_;
    int width_;                       ///< of the picture
    std::vector<glm::vec3> origins_;  ///< by auxiliary sphere; without an atlas the camera's own
    glm::mat3 world_from_camera_;
    std::uint64_t key_;
};

}  // namespace equistream
