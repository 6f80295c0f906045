// Depth of a source's samples from flat views at its centre. Where the four texels around a sample's direction show one
// triangle, or a surface that goes on as it comes within the bound, depth lies between theirs. Elsewhere the triangles
// that they show are met by the sample's own ray: outlines, those of leaves too, lie where rays have them, not where
// texels do. Where it meets none of them, the nearest texel's depth is carried on along its plane.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform sampler2DArray view_depth;
layout(binding = 1) uniform usampler2DArray view_triangle;
layout(binding = 0, r32f) uniform writeonly image2D sphere_depth;

#include "geometry.glsl"
#include "masks.glsl"
#include "source_grid.glsl"
#include "triangles.glsl"

struct FlatView {
    mat4 view_from_source;
    vec4 size;  // columns, rows, focal length in pixels, layer
};
layout(std140, binding = 1) uniform FlatViews {
    FlatView views[MOST_VIEWS];
};

uniform int view_count;
uniform float inverse_depth_scale;
uniform float box_radius_m;
uniform float error;  // of bounded inverse depth
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

/// Of what four texels show, 0 for nothing.
float nearest_hit(uvec4 shown, vec3 direction) {
    float nearest = INFINITE;
    uvec4 seen = uvec4(0u);
    for (int k = 0; k < 4; ++k) {
        uint triangle = shown[k];
        if (triangle != 0u && triangle != seen.x && triangle != seen.y && triangle != seen.z)
            nearest = min(nearest, distance_to(triangle, direction));
        seen[k] = triangle;
    }
    return nearest;
}

/// Four texels of a row or column in order: whether the step in their middle is that on one of its sides.
bool goes_on(vec4 z, float most) {
    vec3 steps = z.yzw - z.xyz;
    return min(abs(steps.y - steps.x), abs(steps.y - steps.z)) <= most;
}

float value_at(int x, int y, int layer) {
    return texelFetch(view_depth, ivec3(x, y, layer), 0).x;
}

/// The rows and columns of the four texels at `low` and after it, with a texel more at either end.
bool is_smooth(ivec2 low, ivec2 size, int layer, vec4 z, float scale) {
    vec4 near_w = box_radius_m * scale * z;
    if (any(lessThanEqual(z, vec4(0.0))) || any(greaterThanEqual(near_w, vec4(1.0))))
        return false;
    // By how much w changes with depth's values.
    vec4 slopes = box_radius_m * scale / ((1.0 - near_w) * (1.0 - near_w));
    float most = error / max(max(slopes.x, slopes.y), max(slopes.z, slopes.w));
    ivec2 before = max(low - 1, ivec2(0)), after = min(low + 2, size - 1);
    vec2 left = vec2(value_at(before.x, low.y, layer), value_at(before.x, low.y + 1, layer));
    vec2 right = vec2(value_at(after.x, low.y, layer), value_at(after.x, low.y + 1, layer));
    vec2 above = vec2(value_at(low.x, before.y, layer), value_at(low.x + 1, before.y, layer));
    vec2 below = vec2(value_at(low.x, after.y, layer), value_at(low.x + 1, after.y, layer));
    return goes_on(vec4(left.x, z.xy, right.x), most) && goes_on(vec4(left.y, z.zw, right.y), most) &&
           goes_on(vec4(above.x, z.xz, below.x), most) && goes_on(vec4(above.y, z.yw, below.y), most);
}

/// Along a unit direction that is `forward` of the view's axis, at a place in the view.
float distance_at(FlatView view, vec2 at, vec3 direction, float forward) {
    ivec2 size = ivec2(view.size.xy), low = clamp(ivec2(floor(at - 0.5)), ivec2(0), size - 2);
    int layer = int(view.size.w);
    uvec4 shown;
    vec4 z;
    for (int k = 0; k < 4; ++k) {
        ivec3 texel = ivec3(low + ivec2(k & 1, k >> 1), layer);
        shown[k] = texelFetch(view_triangle, texel, 0).x;
        z[k] = texelFetch(view_depth, texel, 0).x;
    }
    if (shown == uvec4(0u))
        return INFINITE;
    float scale = inverse_depth_scale * forward;
    if (shown == shown.xxxx || is_smooth(low, size, layer, z, scale)) {
        vec2 weight = at - 0.5 - vec2(low);
        vec2 columns = mix(z.xy, z.zw, weight.y);
        return 1.0 / (scale * mix(columns.x, columns.y, weight.x));
    }
    float nearest = nearest_hit(shown, direction);
    return isinf(nearest) ? 1.0 / (forward * inverse_at(view, at)) : nearest;
}

void main() {
    ivec2 index = ivec2(gl_GlobalInvocationID);
    if (any(greaterThanEqual(index, wanted)))
        return;
    ivec2 s = first + index;
    s.x = (s.x + source_size.x) % source_size.x;
    vec3 d = direction_of(s);
    for (int i = 0; i < view_count; ++i) {
        vec3 seen = mat3(views[i].view_from_source) * d;
        vec2 at = 0.5 * views[i].size.xy + vec2(seen.x, -seen.y) * (views[i].size.z / -seen.z);
        if (seen.z < 0.0 && all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, views[i].size.xy))) {
            imageStore(sphere_depth, s, vec4(distance_at(views[i], at, world_from_source * d, -seen.z)));
            return;
        }
    }
}
