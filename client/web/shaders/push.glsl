// Open layers of a level get colours of the level above; with OF_PIXELS, gap pixels of the first level.
#include "levels.glsl"
#include "push_pull_push.glsl"

uniform float tolerance;

/// From the coarser level, for a layer of this w.
vec3 pushed_at(ivec2 cell, float w) {
    ivec2 beside = 2 * (cell & 1) - 1;
    vec4 around[8];
    for (int k = 0; k < 8; ++k)
        around[k] = coarser_layer(ivec3((cell >> 1) + beside * ivec2((k >> 1) & 1, k >> 2), 0), k & 1);
    return pushed(around, w, tolerance);
}

#ifdef OF_PIXELS
#include "push_pull_depth.glsl"
#include "in_levels.glsl"

uniform sampler2DArray eye_colour;
uniform usampler2DArray eye_origin;

layout(location = 0) out vec4 colour;

void main() {
    ivec3 at = ivec3(gl_FragCoord.xy, 0);
    colour = vec4(texelFetch(eye_colour, at, 0).rgb, 1.0);
    if (texelFetch(eye_origin, at, 0).x != ORIGIN_GAP)
        return;
    vec3 filled = pushed_at(at.xy, w_at(at));
    colour.rgb = filled.r >= 0.0 ? in_levels(filled) : vec3(0.0);
}
#else
uniform sampler2DArray pulled_layers;

layout(location = 0) out vec4 far_layer;
layout(location = 1) out vec4 near_layer;

vec4 coloured(int half_of) {
    vec4 layer = texelFetch(pulled_layers, layer_at(ivec3(gl_FragCoord.xy, 0), half_of), 0);
    bool is_open = layer.w >= 0.0 && layer.r < 0.0;
    return is_open ? vec4(pushed_at(ivec2(gl_FragCoord.xy), layer.w), layer.w) : layer;
}

void main() {
    far_layer = coloured(0);
    near_layer = coloured(1);
}
#endif
