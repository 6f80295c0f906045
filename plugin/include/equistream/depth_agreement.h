#pragma once
/// When a depth sample of the source shows the surface that the eye sees: the project's one bound (bound.h), w = B /
/// (r - B). A sample at r' taken for a point at r is seen displaced by at most asin |w - w'| from anywhere in the ball
/// of radius B, so |w - w'| <= e keeps every colour within the budget e of where it belongs.
///
/// Slopes: a sample lies beside the point, up to a pixel away, and on a tilted surface its depth differs though the
/// surface is the same. Along a plane 1/r is linear in the unit direction, 1/r(q) = m . q, so the plane through the
/// eye's neighbouring pixels predicts the sample's depth exactly; anything between the point's own depth and the
/// prediction, give or take e, is the same surface.
#include <plugin/formulas/scalars.h>

namespace equistream {

using formulas::far_distance_m;

/// The formulas of plugin/formulas/agreement.glsl.h for one head box and one budget.
struct DepthAgreement {
    float box_radius_m = 0;  ///< B
    float tolerance = 0;     ///< sin e

    float clearance(float distance_m) const { return formulas::clearance_of(distance_m, box_radius_m); }
    float w(float distance_m) const { return formulas::w_of(distance_m, box_radius_m); }
    bool same(float clearance_a, float clearance_b) const {
        return formulas::agree(clearance_a, clearance_b, box_radius_m, tolerance);
    }
    bool between(float clearance_point, float clearance_predicted, float clearance_sample) const {
        return formulas::lies_between(clearance_point, clearance_predicted, clearance_sample, box_radius_m, tolerance);
    }
    bool same_inverse(float inverse_a, float inverse_b) const {
        return formulas::agree_inverse(inverse_a, inverse_b, box_radius_m, tolerance);
    }
    bool connected(float before, float a, float b, float after) const {
        return formulas::are_joined(before, a, b, after, box_radius_m, tolerance);
    }
};

}  // namespace equistream
