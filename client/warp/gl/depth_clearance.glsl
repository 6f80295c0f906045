// How far a surface reaches from the head box, and whether two do so alike: formulas of equistream/depth_agreement.h.

// The eye's, set by main().
float box_radius_m;
float tolerance;  // sin e

/// Misses as far away as something may be. NaN stays what it is, of which min() and max() may make a number.
float bounded_distance(float distance_m) {
    return isnan(distance_m) ? UNKNOWN : min(distance_m, FAR_DISTANCE_M);
}

float clearance_of(float distance_m) {
    float r = bounded_distance(distance_m);
    return max(r - box_radius_m, MIN_CLEARANCE_SHARE * r);
}

float w_of(float distance_m) {
    return box_radius_m / clearance_of(distance_m);
}

bool agree(float clearance_a, float clearance_b) {
    return box_radius_m * abs(clearance_a - clearance_b) <= tolerance * (clearance_a * clearance_b) && clearance_b > 0.0;
}

/// agree() for inverse distances.
bool same_inverse(float a, float b) {
    vec2 beyond_box = max(1.0 - box_radius_m * vec2(a, b), vec2(MIN_CLEARANCE_SHARE));
    return box_radius_m * abs(a - b) <= tolerance * (beyond_box.x * beyond_box.y);
}

bool between_inverse(float point, float predicted, float found) {
    return same_inverse(point, found) || same_inverse(predicted, found) || (point < found && found < predicted) ||
           (predicted < found && found < point);
}

/// Whether neighbours `a` and `b` of four samples in a row are joined: show one surface.
bool are_joined(float before, float a, float b, float after) {
    return between_inverse(a, 2.0 * a - before, b) || between_inverse(b, 2.0 * b - after, a);
}
