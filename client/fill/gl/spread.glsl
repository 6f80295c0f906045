// Rung `spread`, as spread_rung.cpp has it: gap pixels take the mean of their filled neighbours' colours, layer after
// layer, until none is left that anybody gives to. One work group goes through all layers of an eye, for a layer's
// colours come from the layers before it only.
layout(local_size_x = 1024) in;

layout(binding = 2) uniform sampler2DArray eye_depth;
layout(binding = 0, rgba8) uniform coherent image2DArray eye_colour;
layout(binding = 1, r8ui) uniform writeonly uimage2DArray filled_origin;

#include "eye_rays.glsl"
#include "spread_lists.glsl"

uniform float inverse_depth_scale;  // of eye_depth's samples: inverse planar depth in 1 / m, 0 for a miss
uniform int has_depth;
uniform int across_surfaces;  // 1: from any neighbour, else from those of the same surface

shared uint candidate_count, layer_count;

const ivec2 AROUND[8] = ivec2[8](ivec2(-1, -1), ivec2(0, -1), ivec2(1, -1), ivec2(-1, 0), ivec2(1, 0), ivec2(-1, 1),
                                 ivec2(0, 1), ivec2(1, 1));

int eye_number;
ivec2 size;
uint pixels;

bool is_inside(ivec2 p) {
    return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size));
}
uint pixel_of(ivec2 p) {
    return uint(p.y * size.x + p.x);
}
ivec2 place_of(uint pixel) {
    return ivec2(int(pixel) % size.x, int(pixel) / size.x);
}
uint state_at(uint pixel) {
    return uint(eye_number) * pixels + pixel;
}
uint candidate_at(uint index) {
    return 2u * uint(eye_number) * pixels + index;
}
uint filled_at(uint index) {
    return (2u * uint(eye_number) + 1u) * pixels + index;
}

/// Radial, in metres: +inf for a miss, NaN where it is not known.
float distance_at(ivec2 p) {
    float z = inverse_depth_scale * texelFetch(eye_depth, ivec3(p, eye_number), 0).x;
    return z == 0.0 ? INFINITE : radial_over_planar(eyes[eye_number], p) / z;
}

float likeness(float a_m, float b_m) {
    if (a_m == b_m)
        return 1.0;
    if (isnan(a_m) || isnan(b_m) || isinf(a_m) || isinf(b_m))
        return LEAST_LIKENESS;
    float difference = abs(a_m - b_m) / min(a_m, b_m);
    return 1.0 / (1.0 + LIKENESS_STEEPNESS * difference * difference);
}

/// Whether a layer has the pixel.
bool fill(uint pixel, uint layer) {
    ivec2 at = place_of(pixel);
    float own_m = has_depth != 0 ? distance_at(at) : 0.0, sum = 0.0;
    vec3 mixed = vec3(0.0);
    for (int k = 0; k < 8; ++k) {
        ivec2 beside = at + AROUND[k];
        if (!is_inside(beside) || states[state_at(pixel_of(beside))] >= layer)
            continue;
        float weight = has_depth != 0 ? likeness(own_m, distance_at(beside)) : 1.0;
        if (across_surfaces == 0 && weight <= SAME_SURFACE_LIKENESS)
            continue;
        sum += weight;
        mixed += weight * imageLoad(eye_colour, ivec3(beside, eye_number)).rgb;
    }
    if (sum == 0.0)
        return false;
    imageStore(eye_colour, ivec3(at, eye_number), vec4(floor(255.0 * mixed / sum + 0.5) / 255.0, 1.0));
    imageStore(filled_origin, ivec3(at, eye_number), uvec4(ORIGIN_NEIGHBOURS));
    states[state_at(pixel)] = layer;
    return true;
}

/// Open pixels around one that was filled come next, each once.
void ask_around(uint pixel, uint next_layer) {
    for (int k = 0; k < 8; ++k) {
        ivec2 beside = place_of(pixel) + AROUND[k];
        if (!is_inside(beside) || states[state_at(pixel_of(beside))] < OPEN)
            continue;
        if (atomicMax(states[state_at(pixel_of(beside))], OPEN | next_layer) < (OPEN | next_layer))
            entries[candidate_at(atomicAdd(candidate_count, 1u))] = pixel_of(beside);
    }
}

void finish_step() {
    memoryBarrier();
    barrier();
}

void main() {
    eye_number = int(gl_WorkGroupID.x);
    size = imageSize(eye_colour).xy;
    pixels = uint(size.x * size.y);
    uint lane = gl_LocalInvocationIndex, count = candidate_counts[eye_number];
    for (uint layer = 1u; count > 0u; ++layer) {
        if (lane == 0u)
            candidate_count = layer_count = 0u;
        finish_step();
        for (uint i = lane; i < count; i += gl_WorkGroupSize.x) {
            uint pixel = entries[candidate_at(i)];
            if (fill(pixel, layer))
                entries[filled_at(atomicAdd(layer_count, 1u))] = pixel;
        }
        finish_step();
        for (uint i = lane; i < layer_count; i += gl_WorkGroupSize.x)
            ask_around(entries[filled_at(i)], layer + 1u);
        finish_step();
        count = candidate_count;
        finish_step();
    }
}
