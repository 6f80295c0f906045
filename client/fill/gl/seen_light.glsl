// What a picture shows of the points that gap pixels see, over a few samples, for they are noisy where light is not
// denoised. The same as ChangedLight of picture_passes.cpp.
layout(local_size_x = 256) in;

layout(binding = 0) uniform sampler2D source_colour;
layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 0, rgba8) uniform writeonly image2DArray eye_colour;

#include "listed_gap.glsl"
#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "eye_surface.glsl"
#include "gap_taps.glsl"
#include "in_levels.glsl"

vec3 colour_at(vec2 position) {
    Taps taps;
    vec4 weights;
    find_taps(position, taps, weights);
    vec3 colour = vec3(0.0);
    for (int k = 0; k < 4; ++k)
        colour += weights[k] * texelFetch(source_colour, taps.places[k], 0).rgb;
    return colour;
}

void main() {
    ivec3 at;
    if (!listed_gap(at))
        return;
    EyeRays eye = eyes[at.z];
    float z = inverse_planar(at);
    if (isnan(z) || z < 0.0)
        return;
    vec2 middle = position_of(ray_of(eye, at.xy) + z * eye.eye.xyz);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < 4; ++k) {
        vec2 around = middle + vec2(k & 1, k >> 1) * 2.0 - 1.0;
        sum += colour_at(vec2(around.x, clamp(around.y, 0.0, float(source_size.y))));
    }
    imageStore(eye_colour, at, vec4(in_levels(0.25 * sum), 1.0));
}
