// When a depth sample of the source shows the surface that the eye sees (depth_agreement.h).
// w = B / (r - B): B is the head box's radius, r a distance from its centre, both in metres.
// `tolerance` is the sine of the angle that colours may be displaced by.

/// Stands for infinity: far enough that w is 0 in single precision, near enough that products stay finite.
CONSTANT float far_distance_m = 1e9f;
/// Inside the box the bound says nothing: this share of r stands for r - B, so that only equal depths agree there.
CONSTANT float min_clearance_share = 1e-3f;

/// Misses lie as far away as something may be. NaN for NaN.
FORMULA Number bounded_distance(Number distance_m) {
    return min_or_nan(distance_m, far_distance_m);
}

/// r - B: the least distance from an eye in the box. NaN for NaN.
FORMULA Number clearance_of(Number distance_m, float box_radius_m) {
    Number r = bounded_distance(distance_m);
    return max(min_clearance_share * r, r - box_radius_m);
}

FORMULA Number w_of(Number distance_m, float box_radius_m) {
    return box_radius_m / clearance_of(distance_m, box_radius_m);
}

/// |w - w'| <= tolerance without dividing. False for NaN, and for a second distance that is not above 0.
FORMULA Truth agree(Number clearance_a, Number clearance_b, float box_radius_m, float tolerance) {
    return both(box_radius_m * abs(clearance_a - clearance_b) <= tolerance * (clearance_a * clearance_b),
                clearance_b > 0.0f);
}

/// Whether a sample's w lies between the point's and what its plane predicts, give or take the tolerance.
FORMULA Truth lies_between(Number point, Number predicted, Number found, float box_radius_m, float tolerance) {
    // With NaN, min() and max() may return either.
    return either(
        either(agree(point, found, box_radius_m, tolerance), agree(predicted, found, box_radius_m, tolerance)),
        either(both(point < found, found < predicted), both(predicted < found, found < point)));
}

/// (r - B) / r, by 1 / r.
FORMULA Number share_beyond_box(Number inverse_m, float box_radius_m) {
    return max(1.0f - box_radius_m * inverse_m, min_clearance_share);
}

/// agree() for inverse distances.
FORMULA Truth agree_inverse(Number a, Number b, float box_radius_m, float tolerance) {
    return box_radius_m * abs(a - b) <=
           tolerance * (share_beyond_box(a, box_radius_m) * share_beyond_box(b, box_radius_m));
}

/// lies_between() for inverse distances.
FORMULA Truth between_inverse(Number point, Number predicted, Number found, float box_radius_m, float tolerance) {
    return either(either(agree_inverse(point, found, box_radius_m, tolerance),
                         agree_inverse(predicted, found, box_radius_m, tolerance)),
                  either(both(point < found, found < predicted), both(predicted < found, found < point)));
}

/// Whether neighbours `a` and `b` of four samples in a row show one surface: what lies before a, or after b,
/// explains the step from one to the other. Inverse distances. NaN is no surface; before and after may be NaN.
FORMULA Truth are_joined(Number before, Number a, Number b, Number after, float box_radius_m, float tolerance) {
    return either(between_inverse(a, 2.0f * a - before, b, box_radius_m, tolerance),
                  between_inverse(b, 2.0f * b - after, a, box_radius_m, tolerance));
}

/// Whether w goes on along a line from the sample `before` through `a` to `b`. Clearances.
FORMULA Truth continues_line(Number before, Number a, Number b, float box_radius_m, float tolerance) {
    return abs(2.0f * box_radius_m / a - box_radius_m / before - box_radius_m / b) <= tolerance;
}
