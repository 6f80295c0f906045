// How far a surface reaches from the head box, and whether two do so alike: formulas of equistream/depth_agreement.h.

// The eye's, set by main().
float box_radius_m;
float tolerance;  // sin e

float reach_of(float distance_m) {
    float r = min(distance_m, FAR_DISTANCE_M);
    return max(r - box_radius_m, LEAST_REACH_SHARE * r);
}

bool agree(float reach_a, float reach_b) {
    return box_radius_m * abs(reach_a - reach_b) <= tolerance * (reach_a * reach_b) && reach_b > 0.0;
}
