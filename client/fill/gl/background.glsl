// The formulas of gaps.h: how far away the background of a gap pixel is. Needs a texture `eye_origin`, and
// INVERSE_PLANAR(at), which gives 1 / planar depth of coloured pixels.
#include "eye_rays.glsl"

/// The distance at which a gap pixel's run ends on one side; NaN at the picture's border.
float end_of_run(ivec3 at, ivec2 step, ivec2 size) {
    for (at.xy += step; all(greaterThanEqual(at.xy, ivec2(0))) && all(lessThan(at.xy, size)); at.xy += step)
        if (texelFetch(eye_origin, at, 0).x != ORIGIN_GAP) {
            float z = INVERSE_PLANAR(at);
            return z > 0.0 ? radial_over_planar(eyes[at.z], at.xy) / z : z == 0.0 ? INFINITE : UNKNOWN;
        }
    return UNKNOWN;
}

/// The farther of two ends, of which either may be unknown.
float farther(float a, float b) {
    return isnan(a) ? b : isnan(b) ? a : max(a, b);
}

/// 1 / planar depth; NaN where all ends are unknown.
float background_inverse(ivec3 at, ivec2 size) {
    float in_row = farther(end_of_run(at, ivec2(-1, 0), size), end_of_run(at, ivec2(1, 0), size));
    float in_column = farther(end_of_run(at, ivec2(0, -1), size), end_of_run(at, ivec2(0, 1), size));
    // The epipolar line's direction here, up to scale: the derivative of the pixel as the eye moves.
    EyeRays eye = eyes[at.z];
    vec3 epipole = eye.eye_own_axes.xyz;
    vec2 aside = vec2(at.xy) - eye.view.yz;
    vec2 along = abs(eye.view.x * vec2(epipole.x, -epipole.y) + aside * epipole.z);
    float depth_m = along.x == along.y  ? farther(in_row, in_column)
                    : along.x > along.y ? (isnan(in_row) ? in_column : in_row)
                                        : (isnan(in_column) ? in_row : in_column);
    return isnan(depth_m) ? UNKNOWN : isinf(depth_m) ? 0.0 : radial_over_planar(eye, at.xy) / depth_m;
}
