// Engine `splat`: every sample of the source as a parallelogram in the eyes' pictures, with the plane of its inverse
// depths, as splat.cpp has it. An invocation has a sample and an eye; the nearest is kept by its key.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0, r32ui) uniform uimage2DArray nearest;  // 0: nothing

#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "source_lattice.glsl"

EyeRays eye;

/// In the eye's picture: pixel centres are whole numbers.
struct Seen {
    vec2 at;
    float inverse_planar;
    bool is_before;
};

Seen seen_at(vec3 q, float k) {
    vec3 point = (q - k * eye.eye.xyz) * mat3(eye.source_from_eye);
    float ahead = -point.z;
    return Seen(eye.view.x * vec2(point.x, -point.y) / ahead + eye.view.yz, k / ahead, ahead > 0.0);
}

/// From one side's middle to the other's, and how far each lies from the sample's place as a share of that.
struct Axis {
    vec2 pixels;
    float inverse_planar;
    float half_length;
};

const float HALF = 0.5 + FOOTPRINT_OVERLAP;

Axis axis_of(ivec2 s, float k, Seen here, ivec2 step) {
    float around[5];
    for (int i = 0; i < 5; ++i)
        around[i] = lattice_inverse(s + (i - 2) * step);
    bool has_before = is_sample(s - step) && are_joined(around[0], around[1], around[2], around[3]);
    bool has_after = is_sample(s + step) && are_joined(around[1], around[2], around[3], around[4]);
    Seen before = seen_at(lattice_direction(s - step), around[1]), after = seen_at(lattice_direction(s + step), around[3]);
    has_before = has_before && before.is_before;
    has_after = has_after && after.is_before;
    vec2 to_here = here.at - before.at, from_here = after.at - here.at;
    float down = here.inverse_planar - before.inverse_planar, up = after.inverse_planar - here.inverse_planar;
    if (has_before && has_after) {
        // Reaches halfway to the farther neighbour.
        vec2 mean = 0.5 * (to_here + from_here);
        float longest = max(length(to_here), length(from_here)), mean_length = length(mean);
        return Axis(mean, 0.5 * (down + up), mean_length > 0.0 ? 0.5 * longest / mean_length + FOOTPRINT_OVERLAP : 0.0);
    }
    if (has_before)
        return Axis(to_here, down, HALF);
    if (has_after)
        return Axis(from_here, up, HALF);
    // On its own: the sample's solid angle at its own distance.
    Seen beside = seen_at(lattice_direction(s + step), k);
    return Axis(beside.at - here.at, beside.inverse_planar - here.inverse_planar, HALF);
}

/// How much wider a sample is at its wider edge than in its middle: much next to a sphere's poles.
float widening(int row) {
    float width[3];
    for (int i = 0; i < 3; ++i)
        width[i] = distance(lattice_direction(ivec2(1, row + i - 1)), lattice_direction(ivec2(0, row + i - 1)));
    return 0.5 + 0.5 * max(width[0], width[2]) / width[1];
}

void main() {
    ivec2 s = ivec2(gl_GlobalInvocationID.xy);
    int eye_number = int(gl_GlobalInvocationID.z);
    if (any(greaterThanEqual(s, source_size)))
        return;
    eye = eyes[eye_number];
    box_radius_m = eye.agreement.x;
    tolerance = eye.agreement.y;
    float k = inverse_of_sample(s);
    Seen here = seen_at(lattice_direction(s), k);
    vec2 last = vec2(imageSize(nearest).xy) - 1.0;
    if (!(k >= 0.0) || !here.is_before || any(lessThan(here.at, vec2(-LARGEST_HALF_SIDE))) ||
        any(greaterThan(here.at, last + 1.0 + LARGEST_HALF_SIDE)))
        return;
    Axis across = axis_of(s, k, here, ivec2(1, 0)), down = axis_of(s, k, here, ivec2(0, 1));
    across.half_length *= widening(s.y);
    float area = across.pixels.x * down.pixels.y - across.pixels.y * down.pixels.x;
    vec2 half_size = across.half_length * abs(across.pixels) + down.half_length * abs(down.pixels);
    // Not its back, nor what is so near to the eye, and so far from the source, that its samples are no picture.
    if (!(area > 0.0) || max(half_size.x, half_size.y) > LARGEST_HALF_SIDE)
        return;
    vec2 u = vec2(down.pixels.y, -down.pixels.x) / area, v = vec2(-across.pixels.y, across.pixels.x) / area;
    vec2 slope = across.inverse_planar * u + down.inverse_planar * v;
    u /= across.half_length;
    v /= down.half_length;
    ivec2 from = ivec2(max(ceil(here.at - half_size), vec2(0.0))), to = ivec2(min(floor(here.at + half_size), last));
    for (int y = from.y; y <= to.y; ++y)
        for (int x = from.x; x <= to.x; ++x) {
            vec2 aside = vec2(x, y) - here.at;
            if (abs(dot(u, aside)) > 1.0 || abs(dot(v, aside)) > 1.0)
                continue;
            // Numbers of at least 0 are ordered as their bits are.
            float inverse_planar = max(here.inverse_planar + dot(slope, aside), 0.0);
            imageAtomicMax(nearest, ivec3(x, y, eye_number), floatBitsToUint(inverse_planar) + 1u);
        }
}
