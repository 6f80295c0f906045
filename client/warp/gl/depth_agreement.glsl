// When a depth sample shows the surface that the eye sees, and where a smooth surface hides a point: the formulas of
// equistream/depth_agreement.h and hiding_surface.h. Needs `float depth_around(ivec2)`, the distance of a sample,
// which may lie up to two beyond the picture's edges; not above 0 where there is none.

#include "depth_clearance.glsl"

bool lies_between(float clearance_point, float clearance_predicted, float clearance_sample) {
    float low = min(clearance_point, clearance_predicted), high = max(clearance_point, clearance_predicted);
    return agree(low, clearance_sample) || agree(high, clearance_sample) || (low < clearance_sample && clearance_sample < high);
}

/// Whether a smooth surface through the sixteen samples around runs before the point; `at` from the first sample's
/// middle.
bool is_hidden(vec2 at, float distance_m) {
    ivec2 corner = ivec2(floor(at));
    vec2 s = at - vec2(corner);
    float k[16];
    for (int i = 0; i < 16; ++i) {
        float sample_m = depth_around(corner + ivec2(i % 4, i / 4) - 1);
        if (!(sample_m > 0.0))
            return false;
        k[i] = 1.0 / clearance_of(sample_m);
    }
    float upper = mix(k[5], k[6], s.x), lower = mix(k[9], k[10], s.x);
    float behind = box_radius_m * (mix(upper, lower, s.y) - 1.0 / clearance_of(distance_m));
    if (!(behind > MIN_BEHIND * tolerance))
        return false;
    float largest = abs((k[5] - k[6]) - (k[9] - k[10]));
    vec2 sums = vec2(0.0);
    for (int line = 0; line < 4; ++line) {
        vec2 sum = vec2(0.0);
        for (int i = 0; i < 2; ++i) {
            vec2 bend = abs(vec2(k[4 * line + i] - 2.0 * k[4 * line + i + 1] + k[4 * line + i + 2],
                                 k[line + 4 * i] - 2.0 * k[line + 4 * i + 4] + k[line + 4 * i + 8]));
            largest = max(largest, max(bend.x, bend.y));
            sum += bend;
        }
        if (line == 1 || line == 2)
            sums = max(sums, sum);
    }
    vec2 off = sums * s * (1.0 - s);
    return box_radius_m * largest <= MAX_BEND * tolerance &&
           behind > MIN_BEHIND * tolerance + box_radius_m * (off.x + off.y);
}
