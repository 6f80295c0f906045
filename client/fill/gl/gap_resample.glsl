// Gap pixels take the colours of what they see from samples on a grid (see gap_resample.cpp): of every pixel of
// another picture, or, with PATCHES, of the blocks of a sphere that an atlas holds.
layout(local_size_x = 256) in;

layout(binding = 0) uniform sampler2D source_colour;
layout(binding = 1) uniform sampler2D source_depth;
layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 0, rgba8) uniform writeonly image2DArray eye_colour;
layout(binding = 1, r8ui) uniform writeonly uimage2DArray filled_origin;  // the same as eye_origin

layout(binding = 5) uniform sampler2DArray image_behind;  // of mirrors (see gap_mirrors.glsl)
layout(binding = 8) uniform sampler2DArray light_then;    // of the sphere around a window (see seen_light.glsl)
layout(binding = 9) uniform sampler2DArray light_now;

#include "listed_gap.glsl"
#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "eye_surface.glsl"
#include "gap_surface.glsl"
#include "in_levels.glsl"

uniform int mark;          // origin of what is filled
uniform int by_direction;  // 1: whatever the distance
uniform int knows_mirrors;  // 1: there is image_behind
uniform int knows_light;    // 1: there are light_then and light_now

vec4 weights_of_direction(ivec3 at, EyeRays eye, out Taps taps) {
    vec2 position = position_of(ray_of(eye, at.xy));
    vec4 weights;
    return is_covered(position) && find_taps(position, taps, weights) && enough(weights) ? weights : NONE;
}

/// Whether samples taken from the source's place have what the eye sees at a pixel, which may be an image: as far behind
/// the surface from either place, nearly.
bool mirrors_show_the_same(ivec3 at, EyeRays eye) {
    if (knows_mirrors == 0)
        return true;
    float behind_m = texelFetch(image_behind, at, 0).x;
    if (isinf(behind_m))
        return true;
    box_radius_m = length(eye.eye.xyz);
    float z = inverse_planar(at), surface_m = min(length(ray_of(eye, at.xy) + z * eye.eye.xyz) / z, FAR_DISTANCE_M);
    float w_image = isnan(behind_m) ? 0.0 : w_of(surface_m + behind_m);
    return abs(w_image - w_of(surface_m)) <= tolerance;
}

bool light_has_changed(ivec3 at) {
    if (knows_light == 0)
        return false;
    vec3 apart = abs(texelFetch(light_then, at, 0).rgb - texelFetch(light_now, at, 0).rgb);
    return max(max(apart.x, apart.y), apart.z) > CHANGED_LIGHT;
}

void main() {
    ivec3 at;
    if (!listed_gap(at))
        return;
    EyeRays eye = eyes[at.z];
    box_radius_m = eye.agreement.x;
    tolerance = eye.agreement.y;
#ifdef PATCHES
    sphere_of_patches = patch_spheres[at.z];
#endif
    Taps taps;
    vec4 weights = by_direction != 0 ? weights_of_direction(at, eye, taps) : weights_of_surface(at, eye, taps);
    if (weights == NONE || (by_direction == 0 && (!mirrors_show_the_same(at, eye) || light_has_changed(at))))
        return;
    vec3 colour = vec3(0.0);
    for (int k = 0; k < 4; ++k)
        if (weights[k] != 0.0)
            colour += weights[k] * texelFetch(source_colour, taps.places[k], 0).rgb;
    imageStore(eye_colour, at, vec4(in_levels(colour / dot(weights, vec4(1.0))), 1.0));
    imageStore(filled_origin, at, uvec4(mark));
}
