#pragma once
/// Between Mitsuba's world, as its XML has it, and ours: +Y up, metres. A rotation by right angles and a scale, so
/// nothing is lost to rounding but the scale.
#include <equistream/camera.h>
#include <host-adapters/mitsuba3/embed/embedded_scene.h>

#include <string>

namespace equistream::mitsuba_host {

struct WorldMap {
    glm::dmat3 ours_from_mitsuba{1};
    double metres_per_unit = 1;

    /// `up`: "x", "y", "z", "-x", "-y", "-z": the axis of Mitsuba's world that becomes +Y.
    static WorldMap with_up(const std::string& up, double metres_per_unit);

    glm::dvec3 point(const glm::dvec3& mitsuba) const { return metres_per_unit * (ours_from_mitsuba * mitsuba); }
    /// A transform between two points of Mitsuba's world as one between points of ours.
    glm::dmat4 transform(const Matrix34& mitsuba) const;
    /// From a camera's to_world; its scale and mirroring are lost.
    Pose pose(const Matrix34& to_world) const;
    Matrix34 to_world(const Pose& pose) const;
};

/// Which axis of Mitsuba's world is nearest to the camera's up: "z", "-x".
std::string nearest_up(const Matrix34& to_world);

glm::dmat4 matrix_of(const Matrix34& rows);
Matrix34 rows_of(const glm::dmat4& matrix);

}  // namespace equistream::mitsuba_host
