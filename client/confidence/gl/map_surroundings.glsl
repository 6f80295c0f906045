// Differences of each pixel to those a source pixel away, and whether it lies at a silhouette or beside another origin:
// the formulas of map_rows-inl.h and contrast_of.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform sampler2DArray eye_colour;
layout(binding = 1) uniform usampler2DArray eye_origin;
layout(binding = 0, rgba8ui) uniform writeonly uimage2DArray surroundings;  // contrast, bend, 1 at a silhouette

#include "map_numbers.glsl"
#include "risks.glsl.h"

ivec2 size;

ivec3 colour_at(ivec3 at) {
    return ivec3(round(255.0 * texelFetch(eye_colour, at, 0).rgb));
}

int worst(ivec3 difference) {
    ivec3 d = abs(difference);
    return max(d.r, max(d.g, d.b));
}

/// Contrast and bend along one axis; nothing where one of the two lies outside.
ivec2 differences(ivec3 at, ivec3 here, ivec2 step) {
    ivec3 before = ivec3(at.xy - step, at.z), after = ivec3(at.xy + step, at.z);
    if (any(lessThan(before.xy, ivec2(0))) || any(greaterThanEqual(after.xy, size)))
        return ivec2(0);
    ivec3 a = colour_at(before), b = colour_at(after);
    return ivec2(max(worst(here - a), worst(here - b)), worst(here - (a + b + 1) / 2));
}

bool is_silhouette(ivec3 at, ivec2 axis, float least) {
    float q[5];
    for (int i = 0; i < 5; ++i)
        q[i] = inverse_planar(ivec3(at.xy + (i - 2) * axis, at.z), size);
    return is_step(q[0], q[1], q[2], q[3], least) || is_step(q[1], q[2], q[3], q[4], least);
}

bool is_border(ivec3 at) {
    uint origin = texelFetch(eye_origin, at, 0).x;
    const ivec2 beside[4] = ivec2[4](ivec2(-1, 0), ivec2(1, 0), ivec2(0, -1), ivec2(0, 1));
    bool differs = false;
    for (int k = 0; k < 4; ++k)
        differs = differs ||
                  texelFetch(eye_origin, ivec3(clamp(at.xy + beside[k], ivec2(0), size - 1), at.z), 0).x != origin;
    return differs;
}

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    size = imageSize(surroundings).xy;
    if (any(greaterThanEqual(at.xy, size)))
        return;
    ivec3 here = colour_at(at);
    int step = numbers[at.z].reach.x;
    ivec2 found = max(differences(at, here, ivec2(step, 0)), differences(at, here, ivec2(0, step)));
    bool mark = is_border(at);
    if (!mark && numbers[at.z].reach.z != 0) {
        float least = numbers[at.z].eye.w;
        mark = is_silhouette(at, ivec2(1, 0), least) || is_silhouette(at, ivec2(0, 1), least);
    }
    imageStore(surroundings, at, uvec4(found, mark ? 1 : 0, 0));
}
