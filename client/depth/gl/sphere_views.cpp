#include "sphere_views.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace equistream::gl {

namespace {

/// Of half a flat view: beyond, its corners are many times denser than its middle.
constexpr double widest_half_rad = 62 * pi / 180;
/// For texels at the border, whose neighbours lie outside.
constexpr double spare_rad = 0.5 * pi / 180;
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

/// Turns -Z to the middle of where all eyes look, and keeps their up.
glm::dquat gaze_of(std::span<const EyeView> eyes) {
    glm::dquat sum = eyes.front().pose.orientation;
    for (const EyeView& eye : eyes.subspan(1)) {
        const double sign = glm::dot(sum, eye.pose.orientation) < 0 ? -1 : 1;
        sum += sign * eye.pose.orientation;
    }
    return glm::normalize(sum);
}

/// How far from the gaze an eye's corner pixels may be looked up, along both axes of the gaze.
struct Reach {
    double x_rad = 0, y_rad = 0;
};

Reach reach_of(const EyeView& eye, const Pose& source, const glm::dquat& gaze) {
    const double offset_m = glm::length(eye.pose.position_m - source.position_m);
    const double parallax = std::asin(std::min(offset_m / nearest_shown_m, 0.95)) + spare_rad;
    Reach reach;
    for (const double u : {0.0, 0.5, 1.0})
        for (const double v : {0.0, 0.5, 1.0}) {
            const glm::dvec3 d =
                glm::conjugate(gaze) *
                (eye.pose.orientation * eye.camera.direction(u * eye.camera.width, v * eye.camera.height));
            reach.x_rad = std::max(reach.x_rad, std::abs(std::atan2(d.x, -d.z)) + parallax);
            reach.y_rad = std::max(reach.y_rad, std::abs(std::atan2(d.y, -d.z)) + parallax);
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

/// Five faces around a gaze: what lies behind it is never looked at.
void add_faces(const glm::dquat& gaze, const Pose& source, double focal_px, const Reach& reach, SphereViews& all) {
    const PerspectiveCamera camera = flat_camera(pi / 4, pi / 4, focal_px);
    all.views.push_back({camera, {source.position_m, gaze}});
    const std::array<glm::dvec3, 2> axes = {glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0)};
    for (const glm::dvec3& axis : axes)
        for (const double turn : {pi / 2, -pi / 2})
            if ((axis.y > 0 ? reach.x_rad : reach.y_rad) > pi / 4)
                all.views.push_back({camera, {source.position_m, gaze * glm::angleAxis(turn, axis)}});
}

}  // namespace

SphereViews sphere_views(const EquirectCamera& camera, const Pose& pose, std::span<const EyeView> eyes) {
    const glm::dquat gaze = gaze_of(eyes);
    Reach reach;
    for (const EyeView& eye : eyes) {
        const Reach one = reach_of(eye, pose, gaze);
        reach = {std::max(reach.x_rad, one.x_rad), std::max(reach.y_rad, one.y_rad)};
    }
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
    const PerspectiveCamera face = flat_camera(pi / 4, pi / 4, density_px(camera));
    const glm::dvec3 x(1, 0, 0), y(0, 1, 0);
    for (const glm::dquat& turn : {glm::dquat(1, 0, 0, 0), glm::angleAxis(pi / 2, y), glm::angleAxis(pi, y),
                                   glm::angleAxis(-pi / 2, y), glm::angleAxis(pi / 2, x), glm::angleAxis(-pi / 2, x)})
        all.views.push_back({face, {pose.position_m, pose.orientation * turn}});
    all.samples = {0, 0, camera.width, camera.height};
    return all;
}

}  // namespace equistream::gl
