#include "world_map.h"

#include <glm/gtc/quaternion.hpp>

#include <cmath>

namespace equistream::mitsuba_host {
namespace {

glm::dmat3 linear_part(const Matrix34& m) {
    return {m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]};
}

/// Takes one axis to +Y and turns no farther than that.
glm::dmat3 rotation_to_y(char axis, bool negative) {
    const double s = negative ? -1 : 1;
    if (axis == 'x')
        return {0, s, 0, -s, 0, 0, 0, 0, 1};
    if (axis == 'z')
        return {1, 0, 0, 0, 0, -s, 0, s, 0};
    return {1, 0, 0, 0, s, 0, 0, 0, s};
}

}  // namespace

glm::dmat4 matrix_of(const Matrix34& m) {
    return {m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, m[3], m[7], m[11], 1};
}

Matrix34 rows_of(const glm::dmat4& m) {
    return {m[0].x, m[1].x, m[2].x, m[3].x, m[0].y, m[1].y, m[2].y, m[3].y, m[0].z, m[1].z, m[2].z, m[3].z};
}

WorldMap WorldMap::with_up(const std::string& up, double metres_per_unit) {
    const bool negative = up.front() == '-';
    return {rotation_to_y(up.back(), negative), metres_per_unit};
}

glm::dmat4 WorldMap::transform(const Matrix34& mitsuba) const {
    glm::dmat4 ours(ours_from_mitsuba * linear_part(mitsuba) * glm::transpose(ours_from_mitsuba));
    ours[3] = glm::dvec4(point({mitsuba[3], mitsuba[7], mitsuba[11]}), 1);
    return ours;
}

Pose WorldMap::pose(const Matrix34& to_world) const {
    const glm::dmat3 axes = ours_from_mitsuba * linear_part(to_world);
    const glm::dvec3 back = -glm::normalize(axes[2]);
    const glm::dvec3 right = glm::normalize(glm::cross(axes[1], back));
    const glm::dmat3 rotation(right, glm::cross(back, right), back);
    return {point({to_world[3], to_world[7], to_world[11]}), glm::normalize(glm::quat_cast(rotation))};
}

Matrix34 WorldMap::to_world(const Pose& pose) const {
    const glm::dmat3 ours = glm::mat3_cast(pose.orientation);
    // Mitsuba's camera frame is +X left, +Y up, +Z forward.
    const glm::dmat3 axes = glm::transpose(ours_from_mitsuba) * glm::dmat3(-ours[0], ours[1], -ours[2]);
    glm::dmat4 matrix(axes);
    matrix[3] = glm::dvec4(glm::transpose(ours_from_mitsuba) * pose.position_m / metres_per_unit, 1);
    return rows_of(matrix);
}

std::string nearest_up(const Matrix34& to_world) {
    const glm::dvec3 up = linear_part(to_world)[1];
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(up[i]) > std::abs(up[axis]))
            axis = i;
    return (up[axis] < 0 ? "-" : "") + std::string(1, "xyz"[axis]);
}

}  // namespace equistream::mitsuba_host
