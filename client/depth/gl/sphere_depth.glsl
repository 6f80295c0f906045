// Depth of a source's samples from flat views at its centre. Inverse planar depth is linear on the screen along a plane:
// the nearest texel's, carried on by the slope to the neighbour that is nearer to it in depth, is exact there.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform sampler2DArray view_depth;
layout(binding = 0, r32f) uniform writeonly image2D sphere_depth;

#include "source_grid.glsl"

struct FlatView {
    mat4 view_from_source;
    vec4 size;  // columns, rows, focal length in pixels, layer
};
layout(std140, binding = 1) uniform FlatViews {
    FlatView views[MOST_VIEWS];
};

uniform int view_count;
uniform float inverse_depth_scale;
uniform ivec2 first;  // of the samples that are wanted
uniform ivec2 wanted;

float believed(float before, float after) {
    return abs(before) <= abs(after) ? before : after;
}

/// Inverse planar depth at a place in a view, in texels.
float inverse_at(FlatView view, vec2 at) {
    ivec2 size = ivec2(view.size.xy), texel = clamp(ivec2(floor(at)), ivec2(0), size - 1);
    int layer = int(view.size.w);
    float z = texelFetch(view_depth, ivec3(texel, layer), 0).x;
    vec2 before, after;
    for (int axis = 0; axis < 2; ++axis) {
        ivec2 step = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
        ivec2 low = max(texel - step, ivec2(0)), high = min(texel + step, size - 1);
        float slope_low = z - texelFetch(view_depth, ivec3(low, layer), 0).x;
        float slope_high = texelFetch(view_depth, ivec3(high, layer), 0).x - z;
        // Beside the border there is one neighbour only.
        before[axis] = low == texel ? slope_high : slope_low;
        after[axis] = high == texel ? slope_low : slope_high;
    }
    vec2 aside = at - (vec2(texel) + 0.5);
    float found = z + believed(before.x, after.x) * aside.x + believed(before.y, after.y) * aside.y;
    return inverse_depth_scale * (z > 0.0 ? max(found, 0.5 * z) : 0.0);
}

void main() {
    ivec2 index = ivec2(gl_GlobalInvocationID);
    if (any(greaterThanEqual(index, wanted)))
        return;
    ivec2 s = first + index;
    s.x = (s.x + source_size.x) % source_size.x;
    vec3 d = direction_of(s);
    float distance_m = uintBitsToFloat(0x7fc00000u);
    for (int i = 0; i < view_count; ++i) {
        vec3 seen = mat3(views[i].view_from_source) * d;
        vec2 at = 0.5 * views[i].size.xy + vec2(seen.x, -seen.y) * (views[i].size.z / -seen.z);
        if (seen.z < 0.0 && all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, views[i].size.xy))) {
            float inverse = inverse_at(views[i], at);
            distance_m = inverse > 0.0 ? 1.0 / (-seen.z * inverse) : uintBitsToFloat(0x7f800000u);
            break;
        }
    }
    imageStore(sphere_depth, s, vec4(distance_m));
}
