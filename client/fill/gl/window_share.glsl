// What the picture of a window counts near the window's border; WindowBorder of base_pass.cpp does the same.
#include "source_grid.glsl"
#include "eye_rays.glsl"

/// Where in the window a pixel's point lies, by inverse planar depth.
vec2 position_in_window(ivec3 at, float z) {
    EyeRays eye = eyes[at.z];
    return position_of(ray_of(eye, at.xy) + z * eye.eye.xyz);
}

/// The window's share of such a pixel's colour: 1 within, 0 on the border and beyond.
float share_of_window(vec2 position) {
    vec2 to_end = vec2(source_size) - position;
    // Where columns close, and over a pole, there is nothing to mix with.
    float inside = source_closes != 0 ? MIXED_PX : min(position.x, to_end.x);
    float rows_above = (quarter_turn - source_top) * rows_per_radian;
    float rows_below = (quarter_turn + source_top) * rows_per_radian - float(source_size.y);
    inside = rows_above > 0.5 ? min(inside, position.y) : inside;
    inside = rows_below > 0.5 ? min(inside, to_end.y) : inside;
    return isnan(inside) || isnan(position.x) ? 1.0 : clamp(inside / MIXED_PX, 0.0, 1.0);
}

/// 1 / m; far away where nobody knows.
float known(float scale, float inverse) {
    return scale == 0.0 || isnan(inverse) ? 0.0 : scale * inverse;
}

/// In whole steps: halves are rounded alike by the CPU and every driver.
vec3 mixed(vec3 base, vec3 window, float share) {
    int steps = int(share * float(MIX_STEPS) + 0.5);
    ivec3 sum = steps * ivec3(round(255.0 * window)) + (MIX_STEPS - steps) * ivec3(round(255.0 * base));
    return vec3((sum + MIX_STEPS / 2) / MIX_STEPS) / 255.0;
}
