#pragma once
/// Poses and cameras: pixel <-> direction both ways. The formulas are those of conventions.h; here they meet
/// GLM and a position in the world. Everything is a plain value; all functions are pure and thread-safe.
#include <equistream/conventions.h>
#include <equistream/image_motion.h>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <variant>

namespace equistream {

/// World from camera: where a camera (or a head) is and how it is turned. Unit quaternion, metres.
struct Pose {
    glm::dvec3 position_m{0, 0, 0};
    glm::dquat orientation{1, 0, 0, 0};  ///< w, x, y, z
};

enum class Eye { centre = 0, left = 1, right = 2 };

/// By Eye: what files, folders and options call them.
inline constexpr const char* eye_names[] = {"centre", "left", "right"};

/// Inter-pupillary distance unless a caller says otherwise.
inline constexpr double default_ipd_m = 0.063;

/// Where an eye of a head is: half the IPD along the head's X axis.
inline glm::dvec3 eye_position(const Pose& head, Eye eye, double ipd_m) {
    const double side = eye == Eye::left ? -0.5 : eye == Eye::right ? 0.5 : 0.0;
    return head.position_m + head.orientation * glm::dvec3(side * ipd_m, 0, 0);
}

/// Whether a sphere's axes stay the world's (a turning head changes nothing in the video) or turn with the path.
enum class AxisLock { world = 0, path = 1 };

/// By AxisLock: what files and options call them.
inline constexpr const char* axis_lock_names[] = {"world", "path"};

struct EquirectCamera {
    int width = 0;
    int height = 0;
    LongitudeLatitudeRange range;
    /// Omnidirectional stereo (ODS): half the interpupillary distance, positive for the right eye, negative for the
    /// left. Each ray then begins at an eye of its own on a circle around the camera's place (origin()). 0: a plain
    /// sphere, whose rays all begin there.
    double ods_side_m = 0;

    /// Unit direction in the camera frame.
    glm::dvec3 direction(double u, double v) const {
        const auto d = equirect_direction<double>({u, v}, width, height, range);
        return {d.x, d.y, d.z};
    }
    glm::dvec2 pixel(const glm::dvec3& d) const {
        const auto p = equirect_pixel<double>({d.x, d.y, d.z}, width, height, range);
        return {p.u, p.v};
    }
    /// Angle between neighbouring pixels on the equator.
    double pixel_angle_rad() const { return range.longitude_span() / width; }
    /// Where the ray of this place begins, in the camera frame, metres.
    glm::dvec3 origin(double u, double v) const {
        const auto at =
            ods_eye_offset(range.longitude_min + u * range.longitude_span() / width,
                           range.latitude_max - v * range.latitude_span() / height, ods_side_m, PoleMerge{});
        return {at.x, at.y, at.z};
    }
    /// In which direction a point is seen, of the camera frame and relative to the camera's place: by ODS from the eye
    /// that looks at it.
    glm::dvec3 direction_to(const glm::dvec3& point_m) const {
        if (ods_side_m == 0)
            return point_m;
        const auto d = ods_direction<double>({point_m.x, point_m.y, point_m.z}, ods_side_m, PoleMerge{});
        return {d.x, d.y, d.z};
    }
};

struct PerspectiveCamera {
    int width = 0;
    int height = 0;
    double fov_x_rad = pi / 2;

    double focal_px() const { return focal_length_px(width, fov_x_rad); }
    /// Unit direction in the camera frame.
    glm::dvec3 direction(double u, double v) const {
        const auto d = perspective_direction<double>({u, v}, width, height, fov_x_rad);
        return glm::normalize(glm::dvec3(d.x, d.y, d.z));
    }
    /// Meaningful only in front of the camera (d.z < 0); NaN otherwise.
    glm::dvec2 pixel(const glm::dvec3& d) const {
        if (!(d.z < 0))
            return glm::dvec2(std::nan(""));
        const auto p = perspective_pixel<double>({d.x, d.y, d.z}, width, height, fov_x_rad);
        return {p.u, p.v};
    }
    /// Angle between neighbouring pixels at the view's centre.
    double pixel_angle_rad() const { return 1 / focal_px(); }
};

using Camera = std::variant<EquirectCamera, PerspectiveCamera>;

inline int width_of(const Camera& camera) {
    return std::visit([](const auto& c) { return c.width; }, camera);
}
inline int height_of(const Camera& camera) {
    return std::visit([](const auto& c) { return c.height; }, camera);
}
/// Whether the last column lies beside the first.
inline bool columns_close(const Camera& camera) {
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    return sphere != nullptr && sphere->range.closes();
}
/// Angle between neighbouring pixels where they lie farthest apart: on the equator, or at the centre of a view.
inline double pixel_angle_rad(const Camera& camera) {
    return std::visit([](const auto& c) { return c.pixel_angle_rad(); }, camera);
}
inline glm::dvec3 direction_of(const Camera& camera, double u, double v) {
    return std::visit([=](const auto& c) { return c.direction(u, v); }, camera);
}
inline glm::dvec2 pixel_of(const Camera& camera, const glm::dvec3& direction) {
    return std::visit([&](const auto& c) { return c.pixel(direction); }, camera);
}

/// Whether every ray begins at an eye of its own.
inline bool is_ods(const Camera& camera) {
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    return sphere != nullptr && sphere->ods_side_m != 0;
}
/// Of omnidirectional stereo for this eye; 0 for the centre.
inline double ods_side_m(Eye eye, double ipd_m) {
    return eye == Eye::left ? -0.5 * ipd_m : eye == Eye::right ? 0.5 * ipd_m : 0.0;
}

/// The pose a camera has for a head: at the eye, or of omnidirectional stereo between both; turned with the head,
/// unless it is a world-locked sphere.
inline Pose camera_pose(const Camera& camera, const Pose& head, Eye eye, double ipd_m, AxisLock lock) {
    const bool world_axes = std::holds_alternative<EquirectCamera>(camera) && lock == AxisLock::world;
    return {eye_position(head, is_ods(camera) ? Eye::centre : eye, ipd_m),
            world_axes ? glm::dquat(1, 0, 0, 0) : head.orientation};
}

}  // namespace equistream
