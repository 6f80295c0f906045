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

/// B for a sphere rendered at the head's centre: radius of the ball that both eyes stay in.
inline double head_box_radius_centre(double head_radius_m, double ipd_m) {
    return head_radius_m + 0.5 * ipd_m;
}

/// B for a sphere rendered at one eye, as in the paper: the other eye is a whole IPD away.
inline double head_box_radius_eye(double head_radius_m, double ipd_m) {
    return head_radius_m + ipd_m;
}

/// B for a sphere rendered at `eye`.
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

/// The largest angle by which any eye in the box can see a point displaced when r' is used for r. The bound does not
/// cover points in the box: if either distance is at most B, the result is pi/2, or 0 for equal distances.
inline double displacement_bound_rad(double distance_m, double used_distance_m, double box_radius_m) {
    const double w = bounded_inverse_depth(distance_m, box_radius_m);
    const double w_used = bounded_inverse_depth(used_distance_m, box_radius_m);
    if (std::isinf(w) || std::isinf(w_used))
        return distance_m == used_distance_m ? 0 : 0.5 * std::acos(-1.0);
    return std::asin(std::min(1.0, std::abs(w - w_used)));
}

/// How far, in metres, a surface at distance r may move along its normal before an eye in the box sees a shift above e,
/// `error_rad`. That is e (r - B) min(1, (r - B) cos t / B). `cos_to_normal` is cos t, of the angle between the ray and
/// the normal. The first term limits the shift of the surface's edges, the second its distance along the ray.
inline double allowed_displacement_m(double distance_m, double cos_to_normal, double box_radius_m, double error_rad) {
    const double beyond_m = std::max(0.0, distance_m - box_radius_m);
    return error_rad * beyond_m * std::min(1.0, beyond_m * cos_to_normal / box_radius_m);
}

/// Default share of the error budget for one approximation. Quantisation, codec, geometry, interpolation and the cells
/// of engine `mesh` each get this share.
inline constexpr double default_budget_share = 0.25;

/// Default error budget of all approximations together, in pixels at the centre of a view.
inline constexpr double default_error_budget_px = 0.25;

/// The error budget as an angle, in a view with this focal length.
inline double error_budget_rad(double focal_length_px, double error_budget_px = default_error_budget_px) {
    return error_budget_px / focal_length_px;
}

/// Focal length of the display that the budget is stated for by default: 1,920 pixels at 90 degrees.
inline constexpr double default_focal_length_px = 960;

/// Columns of a full sphere whose equator has as many pixels per radian as the centre of a view of this focal length.
inline double matching_sphere_width(double focal_length_px) {
    return 2 * std::acos(-1.0) * focal_length_px;
}

}  // namespace equistream
