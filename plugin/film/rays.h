#pragma once
/// The rays one frame asks its host for.
#include <equistream/camera.h>
#include <equistream/equistream.h>

namespace equistream {

/// Immutable after construction; any number of threads.
class FrameRays {
public:
    /// `pose` is the camera's (not the head's).
    FrameRays(const Camera& camera, const Pose& pose, std::uint64_t sequence_seed, std::int64_t frame_index);

    /// Through the centre of pixel (x, y).
    es_ray geometry(int x, int y) const;
    /// Jittered within it: colour pass `sample`.
    es_ray colour(int x, int y, std::uint32_t sample) const;

private:
    es_ray ray(const glm::vec3& direction_camera, int x, int y, std::uint32_t sample) const;
    glm::vec3 direction_float(float u, float v) const;
    float footprint_rad(const glm::vec3& direction_camera) const;

    Camera camera_;
    glm::vec3 origin_;
    glm::mat3 world_from_camera_;
    std::uint64_t key_;
};

}  // namespace equistream
