// Depth of a source's samples from flat views at its centre. The triangles that the four texels around a sample's
// direction show are met by its own ray: outlines, those of leaves too, lie where rays have them, not where texels do.
// Where it meets none of them, the nearest texel's depth is carried on along its plane.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform sampler2DArray view_depth;
layout(binding = 1) uniform usampler2DArray view_triangle;
layout(binding = 0, r32f) uniform writeonly image2D sphere_depth;

#include "geometry.glsl"
#include "masks.glsl"
#include "source_grid.glsl"

layout(std430, binding = 2) readonly buffer Positions {
    float positions[];
};
layout(std430, binding = 3) readonly buffer TextureCoordinates {
    vec2 uvs[];
};
layout(std430, binding = 4) readonly buffer Indices {
    uint indices[];
};

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
uniform vec3 centre_world;
uniform mat3 world_from_source;

float nearer_to_zero(float before, float after) {
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
    float found = z + nearer_to_zero(before.x, after.x) * aside.x + nearer_to_zero(before.y, after.y) * aside.y;
    return inverse_depth_scale * (z > 0.0 ? max(found, 0.5 * z) : 0.0);
}

vec3 corner(uint vertex, mat4 world) {
    uint at = 3u * vertex;
    return (world * vec4(positions[at], positions[at + 1u], positions[at + 2u], 1.0)).xyz - centre_world;
}

/// Distance along a unit direction to a triangle (Moeller and Trumbore 1997), infinite where the ray misses it.
float distance_to(uint triangle, vec3 direction) {
    float miss = INFINITE;
    Item item = items[(triangle - 1u) / MOST_TRIANGLES];
    uint first_index = item.first_index + 3u * ((triangle - 1u) % MOST_TRIANGLES);
    uvec3 vertex = uvec3(indices[first_index], indices[first_index + 1u], indices[first_index + 2u]);
    mat4 world = world_from_object[item.instance];
    vec3 a = corner(vertex.x, world), ab = corner(vertex.y, world) - a, ac = corner(vertex.z, world) - a;
    vec3 p = cross(direction, ac);
    float determinant = dot(ab, p);
    vec3 q = cross(-a, ab);
    vec2 weights = vec2(dot(-a, p), dot(direction, q)) / determinant;
    if (determinant == 0.0 || any(lessThan(weights, vec2(-EDGE))) || weights.x + weights.y > 1.0 + EDGE)
        return miss;
    if (item.masked != 0u) {
        vec2 uv = (1.0 - weights.x - weights.y) * uvs[vertex.x] + weights.x * uvs[vertex.y] + weights.y * uvs[vertex.z];
        if (!covers(mask_of_instance[item.instance], uv))
            return miss;
    }
    float t = dot(ac, q) / determinant;
    return t > 0.0 ? t : miss;
}

/// Of what the four texels around a place in a view show: 0 where that is nothing at all.
float nearest_hit(FlatView view, vec2 at, vec3 direction) {
    ivec2 size = ivec2(view.size.xy), low = ivec2(floor(at - 0.5));
    float nearest = INFINITE;
    uvec4 seen = uvec4(0u);
    for (int k = 0; k < 4; ++k) {
        ivec2 texel = clamp(low + ivec2(k & 1, k >> 1), ivec2(0), size - 1);
        uint triangle = texelFetch(view_triangle, ivec3(texel, int(view.size.w)), 0).x;
        if (triangle != 0u && triangle != seen.x && triangle != seen.y && triangle != seen.z)
            nearest = min(nearest, distance_to(triangle, direction));
        seen[k] = triangle;
    }
    return seen == uvec4(0u) ? 0.0 : nearest;
}

void main() {
    ivec2 index = ivec2(gl_GlobalInvocationID);
    if (any(greaterThanEqual(index, wanted)))
        return;
    ivec2 s = first + index;
    s.x = (s.x + source_size.x) % source_size.x;
    vec3 d = direction_of(s);
    float distance_m = UNKNOWN;
    for (int i = 0; i < view_count; ++i) {
        vec3 seen = mat3(views[i].view_from_source) * d;
        vec2 at = 0.5 * views[i].size.xy + vec2(seen.x, -seen.y) * (views[i].size.z / -seen.z);
        if (seen.z < 0.0 && all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, views[i].size.xy))) {
            distance_m = nearest_hit(views[i], at, world_from_source * d);
            if (isinf(distance_m))
                distance_m = 1.0 / (-seen.z * inverse_at(views[i], at));
            else if (distance_m == 0.0)
                distance_m = INFINITE;
            break;
        }
    }
    imageStore(sphere_depth, s, vec4(distance_m));
}
