// Whether samples show what the eye sees, and where a smooth surface hides a point: agreement.glsl.h and
// hiding.glsl.h for one eye. Needs `float depth_around(ivec2)`, the distance of a sample, which may lie up to
// two beyond the picture's edges; not above 0 where there is none.

#include "depth_clearance.glsl"
#include "hiding.glsl.h"

bool lies_between(float clearance_point, float clearance_predicted, float clearance_sample) {
    return lies_between(clearance_point, clearance_predicted, clearance_sample, box_radius_m, tolerance);
}

/// Whether a smooth surface through the sixteen samples around runs before the point; `at` from the first sample's
/// middle.
bool is_hidden(vec2 at, float distance_m) {
    ivec2 corner = ivec2(floor(at));
    vec2 s = at - vec2(corner);
    float k[16];
    for (int i = 0; i < 16; ++i) {
        float sample_m = depth_around(corner + ivec2(i % 4, i / 4) - 1);
        if (isnan(sample_m) || sample_m <= 0.0)
            return false;
        k[i] = 1.0 / clearance_of(sample_m);
    }
    return surface_hides(k, s.x, s.y, 1.0 / clearance_of(distance_m), box_radius_m, tolerance);
}
