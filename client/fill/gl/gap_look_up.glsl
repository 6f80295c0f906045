// Gap pixels take the colours of what they see from samples on a grid, as gap_look_up.cpp has it: of every pixel of
// another picture, or, with PATCHES, of the blocks of a sphere that an atlas holds.
layout(local_size_x = 256) in;

layout(binding = 0) uniform sampler2D source_colour;
layout(binding = 1) uniform sampler2D source_depth;
layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 0, rgba8) uniform writeonly image2DArray eye_colour;
layout(binding = 1, r8ui) uniform writeonly uimage2DArray filled_origin;  // the same as eye_origin

#include "gap_tiles.glsl"
#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "eye_surface.glsl"
#include "gap_samples.glsl"
#include "depth_agreement.glsl"
#include "wide_gaps.glsl"

uniform int mark;          // origin of what is filled
uniform int by_direction;  // 1: whatever the distance
uniform int wide_only;     // 1: only gaps that wide_gaps.glsl says are wide

const vec4 NONE = vec4(0.0);

#ifdef PATCHES
uniform int unmixed_only;  // 1: only samples whose colours are not mixed with what stands before them

float inverse_around(ivec2 s) {
    return 1.0 / min(depth_around(s), FAR_DISTANCE_M);
}

/// Whether something nearer begins beside a sample: its colour, filtered over the pixel, has a share in it. What a slope
/// explains is the same surface.
bool is_mixed(ivec2 s) {
    float own = inverse_around(s);
    for (int k = 0; k < 4; ++k) {
        ivec2 step = (k & 1) == 0 ? ivec2(k - 1, 0) : ivec2(0, k - 2);
        float beside = inverse_around(s + step);
        if (beside > own && !same_inverse(own, beside) && !same_inverse(2.0 * own - inverse_around(s - step), beside))
            return true;
    }
    return false;
}
#endif

/// The rule of depth_agreement.h, as the engines have it; returns whether all four samples stay.
bool keep_same_surface(ivec3 at, EyeRays eye, float z, Slopes slopes, float reach, Taps taps, inout vec4 weights) {
    bool all_stay = true;
    vec3 gradient = inverse_distance_gradient(eye, at.xy, z, slopes);
    for (int k = 0; k < 4; ++k) {
        if (weights[k] == 0.0) {
            all_stay = false;
            continue;
        }
        float sample_m = texelFetch(source_depth, taps.places[k], 0).x, reach_sample = reach_of(sample_m);
        bool agrees = sample_m > 0.0 && agree(reach, reach_sample);
        if (!agrees && sample_m > 0.0) {
            float inverse = max(dot(gradient, direction_of(taps.samples[k])), 1.0 / FAR_DISTANCE_M);
            agrees = lies_between(reach, reach_of(1.0 / inverse), reach_sample);
        }
        weights[k] = agrees ? weights[k] : 0.0;
        all_stay = all_stay && agrees;
    }
    return all_stay;
}

bool enough(vec4 weights) {
    return dot(weights, vec4(1.0)) > LEAST_WEIGHT;
}

/// Weights of the four samples around what the pixel sees; none where there are too few.
vec4 weights_of_surface(ivec3 at, EyeRays eye, out Taps taps) {
    float z = inverse_planar(at);
    // Also where it is not known.
    if (!(z >= 0.0))
        return NONE;
    vec3 d = ray_of(eye, at.xy) + z * eye.eye.xyz;
    vec2 position = position_of(d);
    Slopes slopes = slopes_at(at, z);
    vec4 weights;
    if (!is_covered(position) || !find_taps(position, taps, weights) || shows_back(eye, at.xy, z, slopes))
        return NONE;
    float distance_m = length(d) / z;
    bool all_stay = keep_same_surface(at, eye, z, slopes, reach_of(distance_m), taps, weights);
    if (!enough(weights) || (!all_stay && is_hidden(position - 0.5, distance_m)))
        return NONE;
#ifdef PATCHES
    for (int k = 0; k < 4 && unmixed_only != 0; ++k)
        if (weights[k] != 0.0 && is_mixed(taps.samples[k]))
            weights[k] = 0.0;
#endif
    return enough(weights) ? weights : NONE;
}

vec4 weights_of_direction(ivec3 at, EyeRays eye, out Taps taps) {
    vec2 position = position_of(ray_of(eye, at.xy));
    vec4 weights;
    return is_covered(position) && find_taps(position, taps, weights) && enough(weights) ? weights : NONE;
}

void main() {
    ivec3 at;
    if (!listed_cell(1, TILE_SHIFT, at) || any(greaterThanEqual(at.xy, imageSize(eye_colour).xy)) ||
        texelFetch(eye_origin, at, 0).x != ORIGIN_GAP)
        return;
    if (wide_only != 0 && !is_wide(pixel_number(at, imageSize(eye_colour).xy)))
        return;
    EyeRays eye = eyes[at.z];
    box_radius_m = eye.agreement.x;
    tolerance = eye.agreement.y;
#ifdef PATCHES
    sphere_of_patches = patch_spheres[at.z];
#endif
    Taps taps;
    vec4 weights = by_direction != 0 ? weights_of_direction(at, eye, taps) : weights_of_surface(at, eye, taps);
    if (weights == NONE)
        return;
    vec3 colour = vec3(0.0);
    for (int k = 0; k < 4; ++k)
        if (weights[k] != 0.0)
            colour += weights[k] * texelFetch(source_colour, taps.places[k], 0).rgb;
    imageStore(eye_colour, at, vec4(colour / dot(weights, vec4(1.0)), 1.0));
    imageStore(filled_origin, at, uvec4(mark));
}
