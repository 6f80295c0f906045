// How far away the background of a gap is, where nobody knows what its pixels see: the formulas of gaps.h.
layout(local_size_x = 256) in;

layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 0, r32f) uniform image2DArray eye_inverse_planar;

#include "gap_tiles.glsl"
#include "eye_rays.glsl"

/// The distance at which a gap pixel's run ends on one side; NaN at the picture's border.
float end_of_run(ivec3 at, ivec2 step, ivec2 size) {
    for (at.xy += step; all(greaterThanEqual(at.xy, ivec2(0))) && all(lessThan(at.xy, size)); at.xy += step)
        if (texelFetch(eye_origin, at, 0).x != ORIGIN_GAP) {
            float z = imageLoad(eye_inverse_planar, at).x;
            return z > 0.0 ? radial_over_planar(eyes[at.z], at.xy) / z : z == 0.0 ? INFINITE : UNKNOWN;
        }
    return UNKNOWN;
}

/// The farther of two ends, of which either may be unknown.
float farther(float a, float b) {
    return isnan(a) ? b : isnan(b) ? a : max(a, b);
}

void main() {
    ivec3 at;
    ivec2 size = imageSize(eye_inverse_planar).xy;
    if (!listed_cell(1, TILE_SHIFT, at) || any(greaterThanEqual(at.xy, size)) ||
        texelFetch(eye_origin, at, 0).x != ORIGIN_GAP)
        return;
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
    float z = isnan(depth_m) ? UNKNOWN : isinf(depth_m) ? 0.0 : radial_over_planar(eye, at.xy) / depth_m;
    imageStore(eye_inverse_planar, at, vec4(z));
}
