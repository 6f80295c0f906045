// An eye's picture of a window with what the sphere around shows: gaps are filled, colours along the border mixed
// (client/fill/gl/window_border.glsl).
#include "window_share.glsl"

uniform sampler2DArray eye_colour;
uniform usampler2DArray eye_origin;
uniform sampler2DArray eye_depth;
uniform sampler2DArray base_colour;
uniform usampler2DArray base_origin;
uniform sampler2DArray base_depth;
uniform float inverse_depth_scale;  // of both depths; 0: there are none

layout(location = 0) out vec4 colour;
layout(location = 1) out uint origin;
layout(location = 2) out float inverse;

void main() {
    ivec3 at = ivec3(gl_FragCoord.xy, 0);
    colour = texelFetch(eye_colour, at, 0);
    origin = texelFetch(eye_origin, at, 0).x;
    inverse = texelFetch(eye_depth, at, 0).x;
    if (texelFetch(base_origin, at, 0).x == ORIGIN_GAP)
        return;
    vec4 base = texelFetch(base_colour, at, 0);
    if (origin == ORIGIN_GAP) {
        colour = base;
        origin = ORIGIN_BASE;
        inverse = texelFetch(base_depth, at, 0).x;
        return;
    }
    float share = share_of_window(position_in_window(at, known(inverse_depth_scale, inverse)));
    if (share < 1.0)
        colour.rgb = mixed(base.rgb, colour.rgb, share);
}
