// A level of the pyramid from the one below; with OF_PIXELS, the first one.
#include "levels.glsl"
#include "push_pull_pull.glsl"

layout(location = 0) out vec4 far_layer;
layout(location = 1) out vec4 near_layer;

uniform float tolerance;

#ifdef OF_PIXELS
#include "push_pull_depth.glsl"

uniform sampler2DArray eye_colour;
uniform usampler2DArray eye_origin;
uniform usampler2D squares;  // that count

bool is_there(ivec3 at) {
    return all(lessThan(at.xy, textureSize(eye_origin, 0).xy)) && texelFetch(squares, at.xy >> TILE_SHIFT, 0).x != 0u;
}

vec4 child_layer(ivec3 at, int half_of) {
    if (half_of == 1 || !is_there(at))
        return NO_LAYER;
    bool is_gap = texelFetch(eye_origin, at, 0).x == ORIGIN_GAP;
    return vec4(is_gap ? OPEN : texelFetch(eye_colour, at, 0).rgb, w_at(at));
}
#else
uniform sampler2DArray finer_layers;
uniform ivec2 finer;  // columns and rows

vec4 child_layer(ivec3 at, int half_of) {
    return all(lessThan(at.xy, finer)) ? texelFetch(finer_layers, layer_at(at, half_of), 0) : NO_LAYER;
}
#endif

void main() {
    vec4 children[8];
    for (int k = 0; k < 8; ++k)
        children[k] = child_layer(ivec3(2 * ivec2(gl_FragCoord.xy) + ivec2(k & 1, (k >> 1) & 1), 0), k >> 2);
    Halves halves = pulled(children, tolerance);
    far_layer = halves.far;
    near_layer = halves.near;
}
