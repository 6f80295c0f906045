#include "convert.h"

#include <equistream/error.h>
#include <equistream/pose_limits.h>

#include <algorithm>
#include <cmath>

namespace equistream::files {

namespace {

/// Both ways of writing a matrix are about; a translation tells which, and without one the preset does.
bool has_column_vectors(const glm::dmat4& m, const SourceConventions& conventions) {
    const double row = std::abs(m[3][0]) + std::abs(m[3][1]) + std::abs(m[3][2]);
    const double column = std::abs(m[0][3]) + std::abs(m[1][3]) + std::abs(m[2][3]);
    if ((row > 1e-9) == (column > 1e-9))
        return conventions.column_vectors;
    return column > 1e-9;
}

}  // namespace

Pose pose_of_attribute(const ForeignExr& file, const SourceConventions& conventions, std::string& taken_for) {
    const glm::dmat4 stored = *file.world_to_camera();  // glm's [i] is the file's row i
    const std::string where = file.file().string() + ": worldToCamera";
    const bool column_vectors = has_column_vectors(stored, conventions);
    // Of column vectors: camera = turn * world + move. glm's columns are the file's rows.
    const glm::dmat4 m = column_vectors ? glm::transpose(stored) : stored;
    glm::dmat3 turn(m);
    glm::dvec3 move(m[3]);
    const glm::dmat3 unity = turn * glm::transpose(turn);
    for (int i = 0; i < 9; ++i)
        if (!(std::abs(unity[i / 3][i % 3] - (i % 4 == 0 ? 1 : 0)) < 1e-3))
            throw InputError(expected_found(where, "a rotation and a translation (--path gives poses instead)",
                                            "a matrix that scales, shears or is 0"));
    const glm::dmat3 flip_z({1, 0, 0}, {0, 1, 0}, {0, 0, -1});
    taken_for = column_vectors ? "column vectors" : "row vectors";
    if (glm::determinant(turn) < 0) {
        taken_for += ", camera looking along +Z";
        turn = flip_z * turn;
        move = flip_z * move;
    } else if (conventions.name == "pbrt") {
        taken_for += ", a left-handed world, whose Z is turned round";
        turn = flip_z * turn * flip_z;
        move = flip_z * move;
    } else {
        taken_for += ", camera looking along -Z";
    }
    const glm::dmat3 world_from_camera = glm::transpose(turn);
    const Pose pose{-(world_from_camera * move), glm::normalize(glm::quat_cast(world_from_camera))};
    if (const auto wrong = position_mismatch(pose.position_m))
        throw InputError(expected_found(where, wrong->expected, wrong->found));
    return pose;
}

std::optional<double> fov_of_attributes(const ForeignExr& file, const SourceConventions& conventions) {
    const auto camera = file.world_to_camera(), ndc = file.world_to_ndc();
    // pbrt itself doubts what it writes there, and it is not what its field of view says unless the picture is square.
    if (!camera || !ndc || conventions.name == "pbrt")
        return std::nullopt;
    const bool column_vectors = has_column_vectors(*camera, conventions);
    const glm::dmat4 turn = column_vectors ? glm::transpose(*camera) : *camera;
    if (std::abs(glm::determinant(turn)) < 1e-9)
        return std::nullopt;
    const glm::dmat4 projection = (column_vectors ? glm::transpose(*ndc) : *ndc) * glm::inverse(turn);
    const double ahead = glm::determinant(glm::dmat3(turn)) < 0 ? 1 : -1;
    const auto across = [&](double x) {
        const glm::dvec4 p = projection * glm::dvec4(x, 0, ahead, 1);
        return p.x / p.w;
    };
    const double middle = across(0), half = std::abs(middle - 0.5) < 1e-3 ? 0.5 : 1;
    const double fov_rad = 2 * std::atan(half / std::abs(across(1) - middle));
    const bool is_centred = half == 0.5 || std::abs(middle) < 1e-3;
    return is_centred && fov_rad > 0.001 && fov_rad < pi - 0.001 ? std::optional(fov_rad) : std::nullopt;
}

Pose pose_from_z_up(const Pose& pose) {
    const glm::dquat turn = glm::angleAxis(-pi / 2, glm::dvec3(1, 0, 0));
    return {turn * pose.position_m, turn * pose.orientation};
}

Pose sphere_pose(const Conversion& conversion, const Pose& camera_pose) {
    if (!std::holds_alternative<EquirectCamera>(conversion.camera))
        return camera_pose;
    const double yaw = 2 * pi * (conversion.conventions.forward_at - 0.5);
    return {camera_pose.position_m, camera_pose.orientation * glm::angleAxis(yaw, glm::dvec3(0, 1, 0))};
}

}  // namespace equistream::files
