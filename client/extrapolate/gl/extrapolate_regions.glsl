// Moving regions on their way (extrapolate.h), in the frame of the picture that shows them. Numbers are from 1; 0: none.
#include "source_grid.glsl"

struct Region {
    mat4 forward, backward;  // of points, metres
    vec4 depths;             // nearest and farthest
    vec4 velocity, turning;  // afterwards: a point at p moves by velocity + turning x p, in a second
};

layout(std430, binding = 0) readonly buffer Regions {
    Region regions[];
};

#ifdef PIECE
/// Runs of pixels in pieces that a work group has threads for: where it begins, row << 16 | column, and region << 8 | count.
layout(std430, binding = 1) readonly buffer Pieces {
    uvec2 pieces[];
};
uniform int piece_count;

/// Of this thread; false: it has none.
bool find_pixel(out ivec2 pixel, out uint region) {
    uint piece = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (piece >= uint(piece_count))
        return false;
    uvec2 words = pieces[piece];
    pixel = ivec2((words.x & 0xffffu) + gl_LocalInvocationID.x, words.x >> 16);
    region = words.y >> 8;
    return gl_LocalInvocationID.x < (words.y & 0xffu);
}
#endif

/// NaN where it is not known.
float region_depth(uint region, float depth_m) {
    vec2 between = regions[region - 1u].depths.xy;
    return depth_m > 0.0 ? clamp(depth_m, between.x, between.y) : UNKNOWN;
}

vec3 moved(mat4 by, vec3 point) {
    return (by * vec4(point, 1.0)).xyz;
}

/// What may come to be seen in a pixel: the distance's upper bits and the region, so that the least is the nearest.
const uint NO_CANDIDATE = 0xffffffffu;

uint candidate_of(float distance_m, uint region) {
    return (floatBitsToUint(distance_m) >> 7) << 8 | region;
}
uint region_of(uint candidate) {
    return candidate & 0xffu;
}
float distance_of(uint candidate) {
    return uintBitsToFloat((candidate >> 8) << 7 | 0x40u);
}
