// Engines `rotation` and `eye-depth`: a pixel of an eye takes its colour from the source, or is left a gap. In plain
// words it is tests/support/references/surface.cpp. BY_SURFACE and ONLY_SEEN say which way.
layout(binding = 0) uniform sampler2D source_colour;
layout(binding = 1) uniform sampler2D source_depth;

#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "eye_surface.glsl"
#include "in_levels.glsl"

/// Of samples up to two beyond the edges.
float depth_around(ivec2 at) {
    return texelFetch(source_depth, wrapped(at), 0).x;
}

#include "depth_agreement.glsl"

/// Transparent: the source did not see it.
vec4 seen_colour(ivec3 at) {
    EyeRays eye = eyes[at.z];
    box_radius_m = eye.agreement.x;
    tolerance = eye.agreement.y;
    vec3 from_source = ray_of(eye, at.xy);
    bool moved = BY_SURFACE && eye.view.w != 0.0;
    float distance_m = FAR_DISTANCE_M, z = 0.0;
    Slopes slopes;
    bool seen = true;
    if (moved) {
        z = inverse_planar(at);
        seen = !isnan(z);
        if (z > 0.0) {
            from_source = eye.eye.xyz + from_source / z;
            distance_m = length(from_source);
        }
    }
    bool judged = ONLY_SEEN && moved;
    if (judged) {
        slopes = slopes_at(at, z);
        seen = seen && !(z > 0.0 && shows_back(eye, at.xy, z, slopes));
    }
    vec2 position = position_of(from_source);
    seen = seen && is_covered(position);
    vec4 colour = vec4(0.0);
    if (seen) {
        vec2 from_first = position - 0.5;
        ivec2 corner = ivec2(floor(from_first));
        vec2 s = from_first - vec2(corner);
        vec3 gradient = judged ? inverse_distance_gradient(eye, at.xy, z, slopes) : vec3(0.0);
        vec3 directions[4] = directions_around(corner);
        float clearance = clearance_of(distance_m), sum = 0.0;
        bool all_agree = true;
        for (int k = 0; k < 4; ++k) {
            ivec2 step = ivec2(k & 1, k >> 1), tap = wrapped(corner + step);
            float weight = (step.x == 0 ? 1.0 - s.x : s.x) * (step.y == 0 ? 1.0 - s.y : s.y);
            if (judged) {
                float sample_m = texelFetch(source_depth, tap, 0).x;
                float clearance_sample = clearance_of(sample_m);
                bool agrees = sample_m > 0.0 && agree(clearance, clearance_sample);
                if (!agrees && sample_m > 0.0) {
                    float inverse = max(dot(gradient, directions[k]), 1.0 / FAR_DISTANCE_M);
                    agrees = lies_between(clearance, clearance_of(1.0 / inverse), clearance_sample);
                }
                weight = agrees ? weight : 0.0;
                all_agree = all_agree && agrees;
            }
            sum += weight;
            colour.rgb += weight * texelFetch(source_colour, tap, 0).rgb;
        }
        seen = sum > MIN_WEIGHT && (all_agree || !is_hidden(from_first, distance_m));
        colour = seen ? vec4(in_levels(colour.rgb / sum), 1.0) : vec4(0.0);
    }
    return colour;
}
