// Depth of the samples that sphere_depth_first.glsl lists: the triangles that the four texels around show are met by the
// sample's own ray, so that outlines, those of leaves too, lie where rays have them, not where texels do. Where it meets
// none of them, the nearest texel's depth is extrapolated along its plane.
layout(local_size_x = 256) in;  // LIST_GROUP

#include "geometry.glsl"
#include "masks.glsl"
#include "triangles.glsl"
#include "sphere_samples.glsl"
#include "pixel_list.glsl"

uniform vec3 centre_world;
uniform mat3 world_from_source;

float nearer_to_zero(float before, float after) {
    return abs(before) <= abs(after) ? before : after;
}

float value_at(int x, int y, int layer) {
    return texelFetch(view_depth, ivec3(x, y, layer), 0).x;
}

/// Inverse planar depth at a place.
float inverse_at(Place place) {
    ivec2 size = place.size, texel = clamp(ivec2(floor(place.at)), ivec2(0), size - 1);
    int layer = place.layer;
    float z = value_at(texel.x, texel.y, layer);
    vec2 before, after;
    for (int axis = 0; axis < 2; ++axis) {
        ivec2 step = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
        ivec2 low = max(texel - step, ivec2(0)), high = min(texel + step, size - 1);
        float slope_low = z - value_at(low.x, low.y, layer);
        float slope_high = value_at(high.x, high.y, layer) - z;
        // Beside the border there is one neighbour only.
        before[axis] = low == texel ? slope_high : slope_low;
        after[axis] = high == texel ? slope_low : slope_high;
    }
    vec2 aside = place.at - (vec2(texel) + 0.5);
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
    Item item = items[(triangle - 1u) / MAX_TRIANGLES];
    uint first_index = item.first_index + 3u * ((triangle - 1u) % MAX_TRIANGLES);
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

void main() {
    uint index = list_index(gl_WorkGroupID, gl_LocalInvocationIndex);
    if (index >= pixel_count)
        return;
    ivec2 s = listed_pixel(index).xy;
    vec3 d = direction_of(s);
    Place place;
    place_of(d, place);
    ivec2 low = texel_before(place);
    uvec4 shown;
    for (int k = 0; k < 4; ++k)
        shown[k] = texelFetch(view_triangle, ivec3(low + ivec2(k & 1, k >> 1), place.layer), 0).x;
    float nearest = nearest_hit(shown, world_from_source * d);
    imageStore(sphere_depth, s, vec4(isinf(nearest) ? 1.0 / (place.forward * inverse_at(place)) : nearest));
}
