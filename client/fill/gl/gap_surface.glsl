// Which samples on a grid show the surface that a gap pixel sees (see PointSamples in gap_resample.cpp). Needs
// source_grid.glsl, eye_rays.glsl, eye_surface.glsl and a texture `source_depth`.

#include "gap_samples.glsl"
#include "depth_agreement.glsl"

const vec4 NONE = vec4(0.0);

#ifdef PATCHES
uniform int unmixed_only;  // 1: only samples whose colours are not mixed with what stands before them

float inverse_around(ivec2 s) {
    return 1.0 / bounded_distance(depth_around(s));
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
bool keep_same_surface(ivec3 at, EyeRays eye, float z, Slopes slopes, float clearance, Taps taps, inout vec4 weights) {
    bool all_stay = true;
    vec3 gradient = inverse_distance_gradient(eye, at.xy, z, slopes);
    for (int k = 0; k < 4; ++k) {
        if (weights[k] == 0.0) {
            all_stay = false;
            continue;
        }
        float sample_m = texelFetch(source_depth, taps.places[k], 0).x, clearance_sample = clearance_of(sample_m);
        bool agrees = sample_m > 0.0 && agree(clearance, clearance_sample);
        if (!agrees && sample_m > 0.0) {
            float inverse = max(dot(gradient, direction_of(taps.samples[k])), 1.0 / FAR_DISTANCE_M);
            agrees = lies_between(clearance, clearance_of(1.0 / inverse), clearance_sample);
        }
        weights[k] = agrees ? weights[k] : 0.0;
        all_stay = all_stay && agrees;
    }
    return all_stay;
}

bool enough(vec4 weights) {
    return dot(weights, vec4(1.0)) > MIN_WEIGHT;
}

/// Weights of the four samples around what the pixel sees; none where there are too few.
vec4 weights_of_surface(ivec3 at, EyeRays eye, out Taps taps) {
    float z = inverse_planar(at);
    if (isnan(z) || z < 0.0)
        return NONE;
    vec3 d = ray_of(eye, at.xy) + z * eye.eye.xyz;
    vec2 position = position_of(d);
    Slopes slopes = slopes_at(at, z);
    vec4 weights;
    if (!is_covered(position) || !find_taps(position, taps, weights) || shows_back(eye, at.xy, z, slopes))
        return NONE;
    float distance_m = length(d) / z;
    bool all_stay = keep_same_surface(at, eye, z, slopes, clearance_of(distance_m), taps, weights);
    if (!enough(weights) || (!all_stay && is_hidden(position - 0.5, distance_m)))
        return NONE;
#ifdef PATCHES
    for (int k = 0; k < 4 && unmixed_only != 0; ++k)
        if (weights[k] != 0.0 && is_mixed(taps.samples[k]))
            weights[k] = 0.0;
#endif
    return enough(weights) ? weights : NONE;
}
