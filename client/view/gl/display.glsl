// A pixel of a window that shows one kind of picture (SHOWN) under one overlay (OVERLAY): a program each,
// for what runs pixel by pixel on a CPU pays for every branch of it. Eyes' rows run down, the window's up.
#include "motion_colour.glsl"
#include "srgb.glsl.h"

layout(binding = 0) uniform sampler2DArray eyes;
layout(binding = 1) uniform sampler2DArray overlaid;
layout(binding = 2) uniform usampler2DArray origins;
layout(binding = 3) uniform sampler2D source;

uniform ivec2 window_size;
uniform ivec2 eye_size;
uniform int middle;  // the column from which on the second eye is shown
uniform float depth_scale;
uniform int has_motion;
uniform mat3 from_left;
uniform mat3 from_right;
uniform vec3 lens;
uniform float fading;
uniform float line;  // where the split is, in columns

out vec4 colour;

vec3 to_linear(vec3 display) {
    return vec3(srgb_to_linear(display.r), srgb_to_linear(display.g), srgb_to_linear(display.b));
}

vec3 to_display(vec3 linear) {
    linear = clamp(linear, 0.0, 1.0);
    return vec3(linear_to_srgb(linear.r), linear_to_srgb(linear.g), linear_to_srgb(linear.b));
}

/// Near is warm, far is cold; 1 / m on a scale that tells rooms and streets apart.
vec3 depth_colour(float inverse_m) {
    if (isnan(inverse_m) || inverse_m <= 0.0)
        return vec3(0.05, 0.05, 0.1);
    float near = clamp(1.0 / (1.0 + 1.0 / HALF_DEPTH / inverse_m), 0.0, 1.0);
    return mix(mix(DEPTH_FAR, DEPTH_MIDDLE, clamp(2.0 * near, 0.0, 1.0)), DEPTH_NEAR, clamp(2.0 * near - 1.0, 0.0, 1.0));
}

/// Who coloured a pixel, in the order of PixelOrigin.
const vec3 origin_colours[] = ORIGIN_COLOURS;

vec3 eye_at(ivec2 at, int layer) {
    at = clamp(at, ivec2(0), eye_size - 1);
    vec3 seen = texelFetch(eyes, ivec3(at, layer), 0).rgb;
#if OVERLAY == OVERLAY_depth
    return depth_scale > 0.0 ? depth_colour(depth_scale * texelFetch(overlaid, ivec3(at, layer), 0).x) : 0.3 * seen;
#elif OVERLAY == OVERLAY_gaps
    uint origin = texelFetch(origins, ivec3(at, layer), 0).x;
    return origin == ORIGIN_SOURCE ? 0.6 * seen : mix(seen, origin_colours[min(origin, uint(origin_colours.length() - 1))], 0.7);
#elif OVERLAY == OVERLAY_reliability
    return mix(UNRELIABLE, seen, texelFetch(overlaid, ivec3(at, layer), 0).x);
#elif OVERLAY == OVERLAY_motion
    vec3 moves = has_motion != 0 ? texelFetch(overlaid, ivec3(at, layer), 0).xyz : vec3(0.0);
    vec3 grey = vec3(0.35 * dot(seen, vec3(0.2126, 0.7152, 0.0722)));
    return moves.z > 0.0 ? motion_colour(moves.xy) : grey;
#else
    return seen;
#endif
}

vec3 behind_lens(ivec2 at, int eye) {
    vec2 from_middle = (vec2(at) + 0.5 - 0.5 * vec2(eye_size)) / (0.5 * float(eye_size.x));
    float r2 = dot(from_middle, from_middle);
    vec2 bent = from_middle * (1.0 + r2 * (lens.x + r2 * lens.y)) / (1.0 + lens.x + lens.y);
    vec2 place = bent * 0.5 * float(eye_size.x) + 0.5 * vec2(eye_size);
    vec2 beyond = max(vec2(0.0), max(-place, place - vec2(eye_size)));
    vec2 low = floor(place - 0.5), weight = place - 0.5 - low;
    ivec2 first = ivec2(low);
    vec3 top = mix(eye_at(first, eye), eye_at(first + ivec2(1, 0), eye), weight.x);
    vec3 bottom = mix(eye_at(first + ivec2(0, 1), eye), eye_at(first + 1, eye), weight.x);
    return mix(top, bottom, weight.y) * clamp(1.0 - max(beyond.x, beyond.y) / 8.0, 0.0, 1.0);
}

/// The whole sphere, fitted into the window.
vec3 whole_sphere(ivec2 at) {
    vec2 size = vec2(textureSize(source, 0)), window = vec2(window_size);
    float scale = max(size.x / window.x, size.y / window.y);
    vec2 place = (vec2(at) + 0.5 - 0.5 * window) * scale + 0.5 * size;
    bool inside = all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, size));
    return inside ? texelFetch(source, ivec2(place), 0).rgb : vec3(0.08);
}

vec3 shown(ivec2 at) {
#if SHOWN == SHOWN_sphere
    return whole_sphere(at);
#elif SHOWN == SHOWN_anaglyph
    return to_display(from_left * to_linear(eye_at(at, 0)) + from_right * to_linear(eye_at(at, 1)));
#else
    int eye = at.x < middle ? 0 : 1;
    ivec2 within = ivec2(at.x - eye * middle, at.y);
#if SHOWN == SHOWN_lens
    return behind_lens(within, eye);
#else
    return eye_at(within, eye);
#endif
#endif
}

void main() {
    vec3 seen = shown(ivec2(gl_FragCoord.x, float(window_size.y) - gl_FragCoord.y));
    seen = abs(gl_FragCoord.x - line) < 1.0 ? vec3(1.0) : seen;
    float grey = dot(seen, vec3(0.2126, 0.7152, 0.0722));
    colour = vec4(mix(seen, mix(vec3(grey), vec3(0.5), 0.6), fading), 1.0);
}
