// Eyes' pictures on the screen, whose rows run up: one, both side by side, or both for red and cyan glasses.
#include "srgb.glsl.h"

uniform sampler2DArray left_eye;
uniform sampler2DArray right_eye;
uniform ivec4 place;  // of the part of the screen that is drawn on: left, bottom, width, height
uniform int layout_of;  // 0: the left picture alone, 1: anaglyph
uniform mat3 from_left;
uniform mat3 from_right;
uniform float fading;  // 0 to 1: how far the picture goes to grey, as in client/view/gl/display.glsl

layout(location = 0) out vec4 colour;

vec3 seen(sampler2DArray eye) {
    ivec2 size = textureSize(eye, 0).xy;
    vec2 at = (gl_FragCoord.xy - vec2(place.xy)) / vec2(place.zw);
    at.y = 1.0 - at.y;
    // Of a screen that has the picture's own pixels these are met exactly.
    return texelFetch(eye, ivec3(clamp(ivec2(at * vec2(size)), ivec2(0), size - 1), 0), 0).rgb;
}

vec3 light(vec3 shown) {
    return vec3(srgb_to_linear(shown.r), srgb_to_linear(shown.g), srgb_to_linear(shown.b));
}

void main() {
    vec3 rgb = seen(left_eye);
    if (layout_of == 1) {
        vec3 mixed = clamp(from_left * light(rgb) + from_right * light(seen(right_eye)), 0.0, 1.0);
        rgb = vec3(linear_to_srgb(mixed.r), linear_to_srgb(mixed.g), linear_to_srgb(mixed.b));
    }
    float grey = dot(rgb, vec3(0.2126, 0.7152, 0.0722));
    colour = vec4(mix(rgb, mix(vec3(grey), vec3(0.5), 0.6), fading), 1.0);
}
