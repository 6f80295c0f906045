// The rays of an eye's pixels in the source's frame (eye_rays.h), for each layer an eye.

struct EyeRays {
    vec4 corner, right, down;  // a pixel's ray has planar depth 1: corner + x right + y down
    vec4 eye;                  // in the source's frame, metres
    vec4 eye_own_axes;         // the same in the eye's own
    mat4 source_from_eye;
    vec4 view;       // focal length, the middle's column and row, all in pixels; 1 where the eye has moved
    vec4 agreement;  // box radius in metres, sin e
};

layout(std140, binding = 1) uniform Eyes {
    EyeRays eyes[MAX_EYES];
};

vec3 ray_of(EyeRays eye, ivec2 pixel) {
    return eye.corner.xyz + float(pixel.x) * eye.right.xyz + float(pixel.y) * eye.down.xyz;
}

/// How much each slope of a pixel's inverse planar depth, per column and per row, turns its surface's front to the
/// source; it shows its back below 0, from 1 - c.z z on, with c the eye's place in its own axes.
vec2 change_by_slope(EyeRays eye, ivec2 pixel) {
    vec3 c = eye.eye_own_axes.xyz;
    return vec2(c.x, -c.y) * eye.view.x + c.z * (vec2(pixel) - eye.view.yz);
}

/// How much longer the way to what a pixel sees is than its planar depth.
float radial_over_planar(EyeRays eye, ivec2 pixel) {
    vec2 aside = (vec2(pixel) - eye.view.yz) / eye.view.x;
    return sqrt(1.0 + dot(aside, aside));
}
