#pragma once
/// Whether a depth sample of the source shows the surface that the eye sees, by the error bound (bound.h): w = B / (r -
/// B). If a sample at r' is used for a point at r, any eye in the ball of radius B sees it displaced by at most
/// asin |w - w'|. So |w - w'| <= e keeps every colour within the budget e of its position.
///
/// Slopes: a sample lies up to a pixel beside the point, so on a tilted surface its depth differs. On a plane 1/r is
/// linear in the unit direction, 1/r(q) = m . q. So the plane through the eye's neighbouring pixels predicts the
/// sample's depth exactly. Any depth between the point's own and the prediction, within e, is the same surface.
#include <plugin/formulas/scalars.h>

namespace equistream {

using formulas::far_distance_m;

/// The formulas of plugin/formulas/agreement.glsl.h for one head box and one error budget. A plain value; NaN is no
/// surface and agrees with nothing.
struct DepthAgreement {
    float box_radius_m = 0;  ///< B
    float tolerance = 0;     ///< sin e

    /// r - B, metres: the distance from the nearest possible eye; at least r / 1000. Misses count as far_distance_m.
    float clearance(float distance_m) const { return formulas::clearance_of(distance_m, box_radius_m); }
    /// B / (r - B).
    float w(float distance_m) const { return formulas::w_of(distance_m, box_radius_m); }
    /// |w - w'| <= tolerance, for two clearances.
    bool same(float clearance_a, float clearance_b) const {
        return formulas::agree(clearance_a, clearance_b, box_radius_m, tolerance);
    }
    /// Whether the sample's w lies between the point's and the predicted one, within the tolerance.
    bool between(float clearance_point, float clearance_predicted, float clearance_sample) const {
        return formulas::lies_between(clearance_point, clearance_predicted, clearance_sample, box_radius_m, tolerance);
    }
    /// same() for inverse distances, in 1/m.
    bool same_inverse(float inverse_a, float inverse_b) const {
        return formulas::agree_inverse(inverse_a, inverse_b, box_radius_m, tolerance);
    }
    /// Whether neighbours a and b of four samples in a row show one surface. Inverse distances, in 1/m; `before` and
    /// `after` may be NaN.
    bool connected(float before, float a, float b, float after) const {
        return formulas::are_joined(before, a, b, after, box_radius_m, tolerance);
    }
};

}  // namespace equistream
