// Rung `geometry`, as geometry_rung.cpp has it: a gap pixel's own surface, lit as filled pixels of its instance around
// are.
layout(local_size_x = 256) in;

layout(binding = 0) uniform usampler2DArray surfaces_seen;
layout(binding = 1) uniform usampler2DArray wanted_tiles;
layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 0, rgba8) uniform image2DArray eye_colour;
layout(binding = 1, r8ui) uniform writeonly uimage2DArray filled_origin;  // the same as eye_origin

#include "gap_tiles.glsl"
#include "srgb.glsl"
#include "surfaces_seen.glsl"

/// What was found of light for a pixel.
struct Light {
    vec3 seen, base;
    int samples;
};

void add_tile(ivec3 tile, ivec3 pixel, uvec4 own, inout Light light) {
    if (texelFetch(wanted_tiles, tile, 0).x == 0u)
        return;
    ivec2 size = imageSize(eye_colour).xy;
    for (int y = 0; y < TILE_SIDE; y += LIGHT_SAMPLE_STEP)
        for (int x = 0; x < TILE_SIDE; x += LIGHT_SAMPLE_STEP) {
            ivec3 at = ivec3((tile.xy << TILE_SHIFT) + ivec2(x, y), tile.z);
            if (any(greaterThanEqual(at.xy, size)))
                continue;
            uvec4 surface = texelFetch(surfaces_seen, at, 0);
            // The same instance, and no gap.
            if (surface.x != (own.x & ~GAP_BIT))
                continue;
            vec2 apart = vec2(at.xy - pixel.xy);
            float facing = max(dot(normal_of(surface), normal_of(own)), 0.0);
            float weight = (facing * facing * facing * facing + LEAST_LIGHT_WEIGHT) / dot(apart, apart);
            vec3 colour = imageLoad(eye_colour, at).rgb;
            light.seen += weight * vec3(srgb_to_linear(colour.r), srgb_to_linear(colour.g), srgb_to_linear(colour.b));
            light.base += weight * max(base_of(surface), vec3(LEAST_BASE));
            ++light.samples;
        }
}

/// From the pixel's own tile outwards, until there are enough samples.
Light light_around(ivec3 pixel, uvec4 own) {
    Light light = Light(vec3(0.0), vec3(0.0), 0);
    ivec2 middle = pixel.xy >> TILE_SHIFT;
    for (int ring = 0; ring <= FARTHEST_LIGHT_TILE && light.samples < ENOUGH_LIGHT_SAMPLES; ++ring)
        for (int y = max(middle.y - ring, 0); y <= min(middle.y + ring, tile_grid.y - 1); ++y) {
            int step = abs(y - middle.y) == ring ? 1 : 2 * ring;
            for (int x = middle.x - ring; x <= middle.x + ring; x += step)
                if (x >= 0 && x < tile_grid.x)
                    add_tile(ivec3(x, y, pixel.z), pixel, own, light);
        }
    return light;
}

float displayed(float linear) {
    return floor(255.0 * linear_to_srgb(clamp(linear, 0.0, 1.0)) + 0.5) / 255.0;
}

void main() {
    ivec3 at;
    if (!listed_cell(1, TILE_SHIFT, at) || any(greaterThanEqual(at.xy, imageSize(eye_colour).xy)) ||
        texelFetch(eye_origin, at, 0).x != ORIGIN_GAP)
        return;
    uvec4 own = texelFetch(surfaces_seen, at, 0);
    if (own.x == 0u)
        return;
    Light light = light_around(at, own);
    if (light.samples == 0)
        return;
    vec3 linear = light.seen / light.base * max(base_of(own), vec3(LEAST_BASE));
    imageStore(eye_colour, at, vec4(displayed(linear.r), displayed(linear.g), displayed(linear.b), 1.0));
    imageStore(filled_origin, at, uvec4(ORIGIN_GEOMETRY));
}
