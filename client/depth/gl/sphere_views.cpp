#include "sphere_views.h"

#include <algorithm>
#include <cmath>

namespace equistream::gl {

namespace {

/// Of half a flat view: beyond, its corners are many times denser than its middle.
constexpr double widest_half_rad = 62 * pi / 180;
/// Around what is looked up, in samples: sixteen taps, the farthest 2 columns and 2 rows away.
constexpr double spare_samples = 3;
/// Points on each side of an eye's picture whose rays are followed.
constexpr int border_steps = 16;
constexpr int least_side = 16;

/// Pixels per radian of the source.
double density_px(const EquirectCamera& camera) {
    return std::max(camera.width / camera.range.longitude_span(), camera.height / camera.range.latitude_span());
}

PerspectiveCamera flat_camera(double half_x_rad, double half_y_rad, double focal_px) {
    const auto side = [focal_px](double half_rad) {
        return std::max(least_side, int(std::ceil(2 * focal_px * std::tan(half_rad))));
    };
    const int width = side(half_x_rad);
    return {width, side(half_y_rad), 2 * std::atan(width / (2 * focal_px))};
}

/// Angle of the taps around what is looked up.
double spare_rad(const EquirectCamera& camera) {
    return spare_samples *
           std::max(camera.range.longitude_span() / camera.width, camera.range.latitude_span() / camera.height);
}

/// Turns -Z to the middle of where all eyes look, and keeps their up.
glm::dquat gaze_of(std::span<const EyeView> eyes) {
    const glm::dquat& first = eyes.front().pose.orientation;
    glm::dquat sum = first;
    for (const EyeView& eye : eyes.subspan(1)) {
        const double sign = glm::dot(sum, eye.pose.orientation) < 0 ? -1 : 1;
        sum += sign * eye.pose.orientation;
    }
    return glm::length(sum) > 1e-3 ? glm::normalize(sum) : first;
}

/// How far from the gaze something may be looked up: towards the sides, up and down, and at all.
struct Reach {
    double x_rad = 0, y_rad = 0, any_rad = 0;

    void include(const Reach& other) {
        x_rad = std::max(x_rad, other.x_rad);
        y_rad = std::max(y_rad, other.y_rad);
        any_rad = std::max(any_rad, other.any_rad);
    }
};

/// Of all directions within an angle of `d`: the largest angle about an axis across the gaze, of which `aside` is d's
/// part; at the poles of that axis a small step goes all the way round.
double angle_about(double aside, double forward, double tilt_rad) {
    const double from_axis = std::hypot(aside, forward);
    if (tilt_rad >= pi / 2 || std::sin(tilt_rad) >= from_axis)
        return pi;
    return std::abs(std::atan2(aside, forward)) + std::asin(std::sin(tilt_rad) / from_axis);
}

Reach reach_of(const EyeView& eye, const Pose& source, const glm::dquat& gaze, double spare) {
    const double share = glm::length(eye.pose.position_m - source.position_m) / nearest_shown_m;
    const double tilt_rad = share < 1 ? std::asin(share) + spare : pi;
    Reach reach;
    const auto follow = [&](double u, double v) {
        const glm::dvec3 d = glm::conjugate(gaze) *
                             (eye.pose.orientation * eye.camera.direction(u * eye.camera.width, v * eye.camera.height));
        reach.include({angle_about(d.x, -d.z, tilt_rad), angle_about(d.y, -d.z, tilt_rad),
                       std::acos(std::clamp(-d.z, -1.0, 1.0)) + tilt_rad});
    };
    for (int step = 0; step <= border_steps; ++step) {
        const double along = double(step) / border_steps;
        for (const double side : {0.0, 1.0}) {
            follow(along, side);
            follow(side, along);
        }
    }
    return reach;
}

/// Samples within an angle of a direction of the source.
SampleRange samples_around(const EquirectCamera& camera, const glm::dvec3& towards, double angle_rad) {
    const double latitude = std::asin(std::clamp(towards.y, -1.0, 1.0));
    const double rows_per_radian = camera.height / camera.range.latitude_span();
    const double columns_per_radian = camera.width / camera.range.longitude_span();
    SampleRange range;
    range.first_row =
        std::max(0, int(std::floor((camera.range.latitude_max - latitude - angle_rad) * rows_per_radian)));
    const int last_row = std::min(
        camera.height, int(std::ceil((camera.range.latitude_max - latitude + angle_rad) * rows_per_radian)) + 1);
    range.rows = std::max(0, last_row - range.first_row);
    range.columns = camera.width;
    if (std::abs(latitude) + angle_rad >= pi / 2 || !camera.range.closes())
        return range;
    const double half_rad = std::asin(std::min(1.0, std::sin(angle_rad) / std::cos(latitude)));
    const double middle = camera.pixel(towards).x;
    const int columns = 2 * int(std::ceil(half_rad * columns_per_radian)) + 2;
    if (columns >= camera.width)
        return range;
    range.columns = columns;
    range.first_column = (int(std::floor(middle)) - columns / 2 + camera.width) % camera.width;
    return range;
}

/// Faces of a cube that looks along the gaze, as far as something in them may be looked up.
void add_faces(const glm::dquat& gaze, const Pose& source, double focal_px, const Reach& reach, SphereViews& all) {
    const PerspectiveCamera camera = flat_camera(pi / 4, pi / 4, focal_px);
    const glm::dvec3 x(1, 0, 0), y(0, 1, 0);
    const auto add = [&](double turn, const glm::dvec3& axis) {
        all.views.push_back({camera, {source.position_m, gaze * glm::angleAxis(turn, axis)}});
    };
    add(0, y);
    const bool sideways = reach.any_rad >= pi / 2;
    for (const double turn : {pi / 2, -pi / 2}) {
        if (sideways || reach.x_rad > pi / 4)
            add(turn, y);
        if (sideways || reach.y_rad > pi / 4)
            add(turn, x);
    }
    if (reach.any_rad > 3 * pi / 4)
        add(pi, y);
}

}  // namespace

SphereViews sphere_views(const EquirectCamera& camera, const Pose& pose, std::span<const EyeView> eyes) {
    const glm::dquat gaze = gaze_of(eyes);
    Reach reach;
    for (const EyeView& eye : eyes)
        reach.include(reach_of(eye, pose, gaze, spare_rad(camera)));
    const glm::dvec3 towards = glm::conjugate(pose.orientation) * (gaze * glm::dvec3(0, 0, -1));
    const double focal_px = density_px(camera);
    SphereViews all;
    if (std::max(reach.x_rad, reach.y_rad) <= widest_half_rad) {
        all.views.push_back({flat_camera(reach.x_rad, reach.y_rad, focal_px), {pose.position_m, gaze}});
        const double corner_rad = std::atan(std::hypot(std::tan(reach.x_rad), std::tan(reach.y_rad)));
        all.samples = samples_around(camera, towards, corner_rad);
        return all;
    }
    add_faces(gaze, pose, focal_px, reach, all);
    all.samples = samples_around(camera, towards, pi);
    return all;
}

SphereViews cube_views(const EquirectCamera& camera, const Pose& pose) {
    SphereViews all;
    add_faces(pose.orientation, pose, density_px(camera), {pi, pi, pi}, all);
    all.samples = {0, 0, camera.width, camera.height};
    return all;
}

}  // namespace equistream::gl
