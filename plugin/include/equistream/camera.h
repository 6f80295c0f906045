#pragma once
/// Poses and cameras: the formulas of conventions.h with GLM types and a position in the world. Everything is a plain
/// value; all functions are pure and thread-safe.
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

/// Where a camera is: at the head's centre, or at an eye. Values are part of the file formats.
enum class Eye { centre = 0, left = 1, right = 2 };

/// Names in files, folders and options, indexed by Eye.
inline constexpr const char* eye_names[] = {"centre", "left", "right"};

/// Inter-pupillary distance unless a caller says otherwise.
inline constexpr double default_ipd_m = 0.063;

/// World position of an eye, in metres: half the IPD from the head's centre along the head's X axis.
inline glm::dvec3 eye_position(const Pose& head, Eye eye, double ipd_m) {
    const double side = eye == Eye::left ? -0.5 : eye == Eye::right ? 0.5 : 0.0;
    return head.position_m + head.orientation * glm::dvec3(side * ipd_m, 0, 0);
}

/// Whether a sphere's axes stay the world's (a turning head changes nothing in the video) or turn with the path.
enum class AxisLock { world = 0, path = 1 };

/// Names in files and options, indexed by AxisLock.
inline constexpr const char* axis_lock_names[] = {"world", "path"};

struct EquirectCamera {
    int width = 0;   ///< pixels
    int height = 0;  ///< pixels
    LongitudeLatitudeRange range;
    /// Omnidirectional stereo (ODS, image_motion.h): half the interpupillary distance, positive for the right eye,
    /// negative for the left. Each ray then begins at its own viewpoint on a circle around the camera (origin()). 0: a
    /// plain sphere, all of whose rays begin at the camera.
    double ods_side_m = 0;

    /// Unit direction, in the camera frame, of continuous pixel coordinates.
    glm::dvec3 direction(double u, double v) const {
        const auto d = equirect_direction<double>({u, v}, width, height, range);
        return {d.x, d.y, d.z};
    }
    /// Continuous pixel coordinates of a direction in the camera frame, of any length.
    glm::dvec2 pixel(const glm::dvec3& d) const {
        const auto p = equirect_pixel<double>({d.x, d.y, d.z}, width, height, range);
        return {p.u, p.v};
    }
    /// Angle between neighbouring pixels on the equator.
    double pixel_angle_rad() const { return range.longitude_span() / width; }
    /// Where the ray through pixel coordinates (u, v) begins: metres, in the camera frame.
    glm::dvec3 origin(double u, double v) const {
        const auto at =
            ods_eye_offset(range.longitude_min + u * range.longitude_span() / width,
                           range.latitude_max - v * range.latitude_span() / height, ods_side_m, PoleMerge{});
        return {at.x, at.y, at.z};
    }
    /// Direction in which a point is seen. Point and result are in the camera frame. With ODS it is the unit direction
    /// from the viewpoint whose column shows the point, otherwise the point itself.
    glm::dvec3 direction_to(const glm::dvec3& point_m) const {
        if (ods_side_m == 0)
            return point_m;
        const auto d = ods_direction<double>({point_m.x, point_m.y, point_m.z}, ods_side_m, PoleMerge{});
        return {d.x, d.y, d.z};
    }
};

struct PerspectiveCamera {
    int width = 0;              ///< pixels
    int height = 0;             ///< pixels
    double fov_x_rad = pi / 2;  ///< horizontal field of view

    double focal_px() const { return focal_length_px(width, fov_x_rad); }
    /// Unit direction in the camera frame.
    glm::dvec3 direction(double u, double v) const {
        const auto d = perspective_direction<double>({u, v}, width, height, fov_x_rad);
        return glm::normalize(glm::dvec3(d.x, d.y, d.z));
    }
    /// Continuous pixel coordinates of a direction in the camera frame, of any length; NaN unless it points forward
    /// (d.z < 0).
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
/// Whether the image closes on itself: a full circle of longitudes, whose last column adjoins the first.
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

/// Whether the camera is omnidirectional stereo: each column has its own viewpoint.
inline bool is_ods(const Camera& camera) {
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    return sphere != nullptr && sphere->ods_side_m != 0;
}
/// EquirectCamera::ods_side_m of omnidirectional stereo for this eye; 0 for the centre.
inline double ods_side_m(Eye eye, double ipd_m) {
    return eye == Eye::left ? -0.5 * ipd_m : eye == Eye::right ? 0.5 * ipd_m : 0.0;
}

/// World-from-camera pose for a head. The position is the eye's, or the head's centre for omnidirectional stereo. A
/// world-locked sphere keeps the world's axes; every other camera turns with the head.
inline Pose camera_pose(const Camera& camera, const Pose& head, Eye eye, double ipd_m, AxisLock lock) {
    const bool world_axes = std::holds_alternative<EquirectCamera>(camera) && lock == AxisLock::world;
    return {eye_position(head, is_ods(camera) ? Eye::centre : eye, ipd_m),
            world_axes ? glm::dquat(1, 0, 0, 0) : head.orientation};
}

}  // namespace equistream
