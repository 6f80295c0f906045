// Base colours of the scene's surfaces, as RayColour and BaseTextures have them. Needs geometry.glsl.

#include "triangles.glsl"

struct Surface {
    float red, green, blue;  // linear
    uint texture, is_matte;
};
layout(std430, binding = 5) readonly buffer Surfaces {
    Surface surfaces[];  // of instances
};
struct TextureRecord {
    uint first_level, level_count, wrap_u, wrap_v;
};
layout(std430, binding = 6) readonly buffer Textures {
    TextureRecord textures[];
};
struct Level {
    int x, y, page, width, height;
};
layout(std430, binding = 7) readonly buffer Levels {
    Level levels[];  // finest first
};
layout(binding = 4) uniform sampler2DArray pages;  // sRGB that comes out linear

int wrapped_texel(int i, int n, uint wrap) {
    if (wrap == WRAP_CLAMP)
        return clamp(i, 0, n - 1);
    int period = wrap == WRAP_MIRROR ? 2 * n : n, m = i - period * int(floor(float(i) / float(period)));
    m += m < 0 ? period : m >= period ? -period : 0;
    return m < n ? m : period - 1 - m;
}

vec3 texel_of(TextureRecord from, Level level, ivec2 at) {
    ivec2 inside = ivec2(wrapped_texel(at.x, level.width, from.wrap_u), wrapped_texel(at.y, level.height, from.wrap_v));
    return texelFetch(pages, ivec3(ivec2(level.x, level.y) + inside, level.page), 0).rgb;
}

float bounded(float coordinate) {
    return abs(coordinate) < FARTHEST_UV ? coordinate : 0.0;
}

/// Bilinear, from the level whose texels are about `footprint` wide.
vec3 texture_at(uint number, vec2 uv, float footprint) {
    TextureRecord from = textures[number];
    if (from.level_count == 0u)
        return vec3(1.0);
    Level finest = levels[from.first_level];
    float texels = max(footprint * float(max(finest.width, finest.height)), 1.0);
    uint wanted = uint(clamp(log2(texels) + 0.5, 0.0, float(from.level_count - 1u)));
    Level level = levels[from.first_level + wanted];
    vec2 at = vec2(bounded(uv.x) * float(level.width), bounded(uv.y) * float(level.height)) - 0.5;
    ivec2 first = ivec2(floor(at));
    vec2 s = at - vec2(first);
    vec3 above = mix(texel_of(from, level, first), texel_of(from, level, first + ivec2(1, 0)), s.x);
    vec3 below = mix(texel_of(from, level, first + ivec2(0, 1)), texel_of(from, level, first + ivec2(1, 1)), s.x);
    return mix(above, below, s.y);
}

/// What a unit ray from the eye sees of a triangle that is known to lie on it.
struct Seen {
    uint instance;
    bool is_matte;
    vec3 base_colour, normal;
};

vec3 corner(uint vertex, mat4 world, vec3 eye) {
    uint at = 3u * vertex;
    return (world * vec4(positions[at], positions[at + 1u], positions[at + 2u], 1.0)).xyz - eye;
}

Seen surface_at(uint triangle, vec3 eye, vec3 ray, float spread_rad) {
    Item item = items[(triangle - 1u) / MOST_TRIANGLES];
    uint first = item.first_index + 3u * ((triangle - 1u) % MOST_TRIANGLES);
    uvec3 vertex = uvec3(indices[first], indices[first + 1u], indices[first + 2u]);
    mat4 world = world_from_object[item.instance];
    vec3 a = corner(vertex.x, world, eye), ab = corner(vertex.y, world, eye) - a, ac = corner(vertex.z, world, eye) - a;
    vec3 across = cross(ab, ac);
    float area = length(across);
    Surface surface = surfaces[item.instance];
    Seen seen = Seen(item.instance, surface.is_matte != 0u, vec3(surface.red, surface.green, surface.blue), -ray);
    if (area > 0.0)
        seen.normal = across / area;
    float cosine = dot(seen.normal, ray);
    if (cosine > 0.0)
        seen.normal = -seen.normal;
    if (surface.texture == NO_TEXTURE)
        return seen;
    // Moeller and Trumbore 1997.
    vec3 p = cross(ray, ac), q = cross(-a, ab);
    float determinant = dot(ab, p);
    vec2 weights = vec2(dot(-a, p), dot(ray, q)) / determinant;
    float distance_m = dot(ac, q) / determinant;
    vec2 u = uvs[vertex.y] - uvs[vertex.x], v = uvs[vertex.z] - uvs[vertex.x];
    float uv_per_m = sqrt(abs(u.x * v.y - u.y * v.x) / max(area, LEAST_AREA_M2));
    float width_m = spread_rad * distance_m / sqrt(max(abs(cosine), LEAST_SEEN_COSINE));
    seen.base_colour *=
        texture_at(surface.texture, uvs[vertex.x] + weights.x * u + weights.y * v, width_m * uv_per_m);
    return seen;
}
