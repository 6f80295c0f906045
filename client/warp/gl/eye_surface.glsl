// The surface that an eye's pixel sees, by the inverse planar depths around: the formulas of eye_rays.cpp. Needs
// eye_rays.glsl, and EYE_SIZE or an image `eye_colour` of the eyes' size.
#ifndef EYE_SIZE
#define EYE_SIZE imageSize(eye_colour).xy
#endif

layout(binding = 2) uniform sampler2DArray eye_depth;
uniform float inverse_depth_scale;  // of eye_depth's samples: inverse planar depth in 1 / m, 0 for a miss

/// NaN outside the view.
float inverse_planar(ivec3 at) {
    if (any(lessThan(at.xy, ivec2(0))) || any(greaterThanEqual(at.xy, EYE_SIZE)))
        return UNKNOWN;
    return inverse_depth_scale * texelFetch(eye_depth, at, 0).x;
}

struct Slopes {
    vec2 before, after;  // per column and per row
};

Slopes slopes_at(ivec3 at, float z) {
    return Slopes(z - vec2(inverse_planar(at - ivec3(1, 0, 0)), inverse_planar(at - ivec3(0, 1, 0))),
                  vec2(inverse_planar(at + ivec3(1, 0, 0)), inverse_planar(at + ivec3(0, 1, 0))) - z);
}

float believed(float before, float after) {
    if (isnan(before))
        return isnan(after) ? 0.0 : after;
    return isnan(after) || abs(before) <= abs(after) ? before : after;
}

float max_product(float before, float after, float factor) {
    float a = before * factor, b = after * factor;
    return isnan(a) ? b : isnan(b) ? a : max(a, b);
}

/// Whether the source sees the back of what the eye sees, through whichever neighbours its plane is laid.
bool shows_back(EyeRays eye, ivec2 pixel, float z, Slopes slopes) {
    vec2 change = change_by_slope(eye, pixel);
    return 1.0 - eye.eye_own_axes.z * z + max_product(slopes.before.x, slopes.after.x, change.x) +
               max_product(slopes.before.y, slopes.after.y, change.y) < 0.0;
}

/// 1 / distance = gradient . q along the plane at a pixel, for distances from the source's centre.
vec3 inverse_distance_gradient(EyeRays eye, ivec2 pixel, float z, Slopes slopes) {
    vec2 slope = vec2(believed(slopes.before.x, slopes.after.x), believed(slopes.before.y, slopes.after.y));
    vec2 aside = vec2(pixel) - eye.view.yz;
    vec3 n = vec3(slope.x * eye.view.x, -slope.y * eye.view.x, dot(slope, aside) - z);
    vec3 m = mat3(eye.source_from_eye) * n;
    return m / (1.0 + dot(m, eye.eye.xyz));
}
