// agreement.glsl.h for one eye: its head box and its budget.
#include "agreement.glsl.h"

// Set by main().
float box_radius_m;
float tolerance;  // sin e

float clearance_of(float distance_m) {
    return clearance_of(distance_m, box_radius_m);
}

float w_of(float distance_m) {
    return w_of(distance_m, box_radius_m);
}

bool agree(float clearance_a, float clearance_b) {
    return agree(clearance_a, clearance_b, box_radius_m, tolerance);
}

bool same_inverse(float a, float b) {
    return agree_inverse(a, b, box_radius_m, tolerance);
}

bool are_joined(float before, float a, float b, float after) {
    return are_joined(before, a, b, after, box_radius_m, tolerance);
}
