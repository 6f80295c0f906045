// What the geometry has at gap pixels, and at those filled pixels around that are asked for their light.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform usampler2DArray view_triangle;
layout(binding = 1) uniform usampler2DArray wanted_tiles;
layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 0, rgba32ui) uniform writeonly uimage2DArray surfaces_seen;

#include "geometry.glsl"
#include "eye_rays.glsl"
#include "surface_colours.glsl"
#include "surfaces_seen.glsl"

uniform float spread_rad;  // between rays of neighbouring pixels

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at.xy, textureSize(eye_origin, 0).xy)) ||
        texelFetch(wanted_tiles, ivec3(at.xy >> TILE_SHIFT, at.z), 0).x == 0u)
        return;
    bool is_gap = texelFetch(eye_origin, at, 0).x == ORIGIN_GAP;
    if (!is_gap && any(notEqual(at.xy % LIGHT_SAMPLE_STEP, ivec2(0))))
        return;
    uint triangle = texelFetch(view_triangle, at, 0).x;
    uvec4 packed_seen = uvec4(0u);
    if (triangle != 0u) {
        EyeRays eye = eyes[at.z];
        Seen seen = surface_at(triangle, eye.eye.xyz, normalize(ray_of(eye, at.xy)), spread_rad);
        if (seen.is_matte)
            packed_seen = packed_surface(seen.instance, is_gap, seen.base_colour, seen.normal);
    }
    imageStore(surfaces_seen, at, packed_seen);
}
