#pragma once
/// Motion in pixels of a frame's own image, from its pixels to where the same points are in a neighbouring frame.
#include <equistream/camera.h>

namespace equistream {

/// Immutable; any number of threads. Results are always finite: on a sphere by the shortest way round the seam; in a
/// perspective view, a point behind the other camera (or nearly beside it) is put out of the image in its own
/// direction from the centre, perspective_limit_px() away.
class Motion {
public:
    /// Camera poses of this frame and of the neighbour.
    Motion(const Camera& camera, const Pose& here, const Pose& there);

    /// Of a surface point seen at continuous pixel (u, v) here, whose world position in the neighbour is given.
    glm::dvec2 of_point(glm::dvec2 pixel, const glm::dvec3& position_there_m) const;
    /// Of something infinitely far away: by rotation only.
    glm::dvec2 of_direction(glm::dvec2 pixel) const;

private:
    glm::dvec2 difference(glm::dvec2 pixel, const glm::dvec3& direction_there) const;

    Camera camera_;
    Pose here_;
    Pose there_;
    glm::dquat there_from_world_;
};

}  // namespace equistream
