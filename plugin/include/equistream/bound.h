#pragma once
/// The error bound that sizes every approximation (docs/conventions.md, "One bound").
///
/// Eyes stay in a ball of radius B around the sphere's centre; a point lies at radial distance r > B.
/// If r' is used for r, an eye anywhere in the ball sees the point displaced by at most
/// asin |w(r) - w(r')|, with w(r) = B / (r - B). All functions are pure; lengths in metres, angles in radians.
#include <equistream/camera.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream {

/// Radius of the ball that both eyes stay in, around a sphere rendered at the head's centre.
inline double head_box_radius_centre(double head_radius_m, double ipd_m) {
    return head_radius_m + 0.5 * ipd_m;
}

/// The same around a sphere rendered at one eye, as in the paper: the other eye is a whole IPD away.
inline double head_box_radius_eye(double head_radius_m, double ipd_m) {
    return head_radius_m + ipd_m;
}

/// Either of them, by where the sphere was rendered.
inline double head_box_radius(Eye eye, double head_radius_m, double ipd_m) {
    return eye == Eye::centre ? head_box_radius_centre(head_radius_m, ipd_m)
                              : head_box_radius_eye(head_radius_m, ipd_m);
}

/// w = B / (r - B): 0 at infinity, growing towards the head box; +inf at or inside it.
inline double bounded_inverse_depth(double distance_m, double box_radius_m) {
    if (std::isinf(distance_m))
        return 0;
    if (distance_m <= box_radius_m)
        return std::numeric_limits<double>::infinity();
    return box_radius_m / (distance_m - box_radius_m);
}

/// The largest angle by which any eye in the box can see a point displaced when r' stands for r; where either point is
/// not outside the box, which the bound does not cover, a right angle unless they are one.
inline double displacement_bound_rad(double distance_m, double used_distance_m, double box_radius_m) {
    const double w = bounded_inverse_depth(distance_m, box_radius_m);
    const double w_used = bounded_inverse_depth(used_distance_m, box_radius_m);
    if (std::isinf(w) || std::isinf(w_used))
        return distance_m == used_distance_m ? 0 : 0.5 * std::acos(-1.0);
    return std::asin(std::min(1.0, std::abs(w - w_used)));
}

/// How far, in metres, a surface at distance r may move along its normal for no eye in the box to see a shift above
/// `error_rad`; `cos_to_normal` is of the angle it is looked at. Seen square on, what moves is its edges; seen
/// aslant, its distance along the ray.
inline double allowed_displacement_m(double distance_m, double cos_to_normal, double box_radius_m, double error_rad) {
    const double beyond_m = std::max(0.0, distance_m - box_radius_m);
    return error_rad * beyond_m * std::min(1.0, beyond_m * cos_to_normal / box_radius_m);
}

/// What one approximation of several gets of the budget unless a measurement says otherwise: quantisation, codec,
/// geometry and mesh share it.
inline constexpr double default_budget_share = 0.25;

/// The whole budget unless somebody wants another: this share of a pixel at the centre of a view.
inline constexpr double default_error_budget_px = 0.25;

/// The same as an angle, in a view with this focal length.
inline double error_budget_rad(double focal_length_px, double error_budget_px = default_error_budget_px) {
    return error_budget_px / focal_length_px;
}

/// Focal length of the display that the budget is stated for by default: 1,920 pixels at 90 degrees.
inline constexpr double default_focal_length_px = 960;

/// Columns of a sphere that is as dense as the centre of a view of this focal length.
inline double matching_sphere_width(double focal_length_px) {
    return 2 * std::acos(-1.0) * focal_length_px;
}

}  // namespace equistream
