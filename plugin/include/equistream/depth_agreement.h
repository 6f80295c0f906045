#pragma once
/// When a depth sample of the source shows the surface that the eye sees: the project's one bound (bound.h), w = B /
/// (r - B). A sample at r' taken for a point at r is seen displaced by at most asin |w - w'| from anywhere in the ball
/// of radius B, so |w - w'| <= e keeps every colour within the budget e of where it belongs.
///
/// Slopes: a sample lies beside the point, up to a pixel away, and on a tilted surface its depth differs though the
/// surface is the same. Along a plane 1/r is linear in the unit direction, 1/r(q) = m . q, so the plane through the
/// eye's neighbouring pixels predicts the sample's depth exactly; anything between the point's own depth and the
/// prediction, give or take e, is the same surface.
#include <algorithm>
#include <cmath>

namespace equistream {

/// Stands for infinity: far enough that w is 0 in single precision, near enough that products stay finite.
inline constexpr float far_distance_m = 1e9f;
/// Inside the box the bound says nothing: this share of r stands for r - B, so that only equal depths agree there.
inline constexpr float min_clearance_share = 1e-3f;

struct DepthAgreement {
    float box_radius_m = 0;  ///< B
    float tolerance = 0;     ///< sin e

    /// r - B: the least distance from an eye in the box.
    float clearance(float distance_m) const {
        const float r = std::min(distance_m, far_distance_m);
        return std::max(r - box_radius_m, min_clearance_share * r);
    }
    /// |w - w'| <= sin e without dividing. False for NaN and for distances <= 0.
    bool same(float clearance_a, float clearance_b) const {
        return box_radius_m * std::abs(clearance_a - clearance_b) <= tolerance * (clearance_a * clearance_b) &&
               clearance_b > 0;
    }
    /// Whether `clearance_sample` lies between the point's and the prediction's, give or take the tolerance, in w.
    bool between(float clearance_point, float clearance_predicted, float clearance_sample) const {
        const auto [low, high] = std::minmax(clearance_point, clearance_predicted);
        return same(low, clearance_sample) || same(high, clearance_sample) ||
               (low < clearance_sample && clearance_sample < high);
    }

    /// The same rule for inverse distances 1/r >= 0 (w = B/r / (1 - B/r), so nothing is divided): (r - B) / r.
    float share_beyond_box(float inverse_m) const {
        return std::max(1 - box_radius_m * inverse_m, min_clearance_share);
    }
    bool same_inverse(float inverse_a, float inverse_b) const {
        return box_radius_m * std::abs(inverse_a - inverse_b) <=
               tolerance * (share_beyond_box(inverse_a) * share_beyond_box(inverse_b));
    }
    bool between_inverse(float point, float predicted, float sample) const {
        // Without a branch, so that loops over rows of samples become vector code.
        return bool(int(same_inverse(point, sample)) | int(same_inverse(predicted, sample)) |
                    (int(point < sample) & int(sample < predicted)) | (int(predicted < sample) & int(sample < point)));
    }
    /// Whether neighbours `a` and `b` of four samples in a row show one surface: what lies before a, or after b,
    /// explains the step from one to the other. NaN is no surface; before and after may be NaN.
    bool connected(float before, float a, float b, float after) const {
        return bool(int(between_inverse(a, 2 * a - before, b)) | int(between_inverse(b, 2 * b - after, a)));
    }
};

}  // namespace equistream
