// What resample.glsl does, for pixels where that is simple: those that see nothing, and those where the depths of all
// four samples around say the same as the eye's. The others go on a list. Where lanes run both sides of every branch,
// the whole rule would cost all pixels what few need.
layout(binding = 0) uniform sampler2D source_colour;
layout(binding = 1) uniform sampler2D source_depth;
layout(binding = 2) uniform sampler2DArray eye_depth;

layout(location = 0) out vec4 colour;
layout(location = 1) out uint origin;

#define GRID_BY_VERTEX
#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "depth_clearance.glsl"
#include "pixel_list.glsl"

in EyeConstants {
    flat EyeRays eye;
    flat int eye_number;
    flat ivec2 eye_size;
    flat float inverse_depth_scale;  // (see eye_surface.glsl)
};

/// Whether the source sees the front of what the eye sees through one neighbour along each axis, that of the two by two
/// pixels around; shows_back takes the better of both, so that what is true here is never false there.
bool shows_front(EyeRays eye, ivec2 pixel, float z, vec2 slope) {
    return 1.0 - eye.eye_own_axes.z * z + dot(slope, change_by_slope(eye, pixel)) >= 0.0;
}

bool all_agree(vec2 position, float distance_m) {
    // At the corner that the four samples share, a gather finds those and no others.
    vec4 samples_m = textureGather(source_depth, floor(position + 0.5) / vec2(source_size));
    float clearance = clearance_of(distance_m);
    bool holds = true;
    for (int k = 0; k < 4; ++k)
        holds = both(holds, both(samples_m[k] > 0.0, agree(clearance, clearance_of(samples_m[k]))));
    return holds;
}

/// Of the four samples around, with weights in steps of 1 / POSITION_ONE, as warp_colour-inl.h mixes them: what is
/// beside an edge of a picture goes on the list.
vec3 mixed_around(vec2 position) {
    ivec2 at = ivec2(roundEven(float(POSITION_ONE) * (position - 0.5)));
    ivec2 first = clamp(at >> POSITION_BITS, ivec2(0), max(source_size - 2, 0)), f = at - (first << POSITION_BITS);
    int both = f.x * f.y + POSITION_ONE / 2 >> POSITION_BITS;
    vec4 weights = vec4(POSITION_ONE - f.x - f.y + both, f.x - both, f.y - both, both) * (255.0 / float(POSITION_ONE));
    vec3 sum = weights.x * texelFetch(source_colour, first, 0).rgb +
               weights.y * texelFetchOffset(source_colour, first, 0, ivec2(1, 0)).rgb +
               weights.z * texelFetchOffset(source_colour, first, 0, ivec2(0, 1)).rgb +
               weights.w * texelFetchOffset(source_colour, first, 0, ivec2(1)).rgb;
    // Sums are whole numbers of steps: a quarter of one more, so that halves go up whatever was lost on the way.
    return floor(sum + (0.5 + 0.25 / float(POSITION_ONE))) / 255.0;
}

void main() {
    box_radius_m = eye.agreement.x;
    tolerance = eye.agreement.y;
    ivec3 at = ivec3(gl_FragCoord.xy, eye_number);
    vec3 from_source = ray_of(eye, at.xy);
    bool moved = BY_SURFACE && eye.view.w != 0.0, seen = true, simple = true;
    float distance_m = FAR_DISTANCE_M, z = UNKNOWN;
    if (moved && all(lessThan(at.xy, eye_size)))
        z = inverse_depth_scale * texelFetch(eye_depth, at, 0).x;
    // Not in a branch: there its neighbours may have none.
    vec2 slope = vec2(dFdxFine(z), dFdyFine(z));
    if (moved) {
        seen = !isnan(z);
        simple = !ONLY_SEEN || z <= 0.0 || shows_front(eye, at.xy, z, slope);
        from_source += max(z, 0.0) * eye.eye.xyz;  // times the point's planar depth
        distance_m = z > 0.0 ? length(from_source) / z : FAR_DISTANCE_M;
    }
    vec2 position = position_of(from_source);
    seen = seen && is_covered(position);
    // What is mixed here does not go round.
    simple = simple && all(greaterThanEqual(position, vec2(0.5))) &&
             all(lessThan(position, vec2(source_size) - 0.5)) && (!ONLY_SEEN || !moved || all_agree(position, distance_m));
    colour = seen ? vec4(mixed_around(position), 1.0) : vec4(0.0);
    origin = seen ? ORIGIN_SOURCE : ORIGIN_GAP;
    if (seen && !simple)
        append(at);
}
