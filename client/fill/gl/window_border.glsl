// Where eyes see the border of the window that their source is, as WindowBorder of picture_passes.cpp has it. With FIND
// the tiles there are found, with OPEN their pixels are made gaps of other targets, which the sphere around then fills,
// and else both are mixed. Tiles whose corners all lie well within the window are passed over: where no border is in
// view nothing is done but to look at those. The CPU cannot tell by the eyes' frustums, for it knows of no depth.
#ifdef FIND
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;
#else
layout(local_size_x = 256) in;
#endif

layout(binding = 2) uniform sampler2DArray eye_depth;

#include "gap_tiles.glsl"
#include "source_grid.glsl"
#include "eye_rays.glsl"

uniform float inverse_depth_scale;  // of its samples; 0: what is seen is known by direction alone

/// The window's share of a pixel's colour: 1 within, 0 on the border.
float share_of_window(ivec3 at) {
    EyeRays eye = eyes[at.z];
    float z = inverse_depth_scale == 0.0 ? 0.0 : inverse_depth_scale * texelFetch(eye_depth, at, 0).x;
    vec2 position = position_of(ray_of(eye, at.xy) + z * eye.eye.xyz), to_end = vec2(source_size) - position;
    float inside = min(position.x, to_end.x);
    // Over a pole there is nothing to mix with.
    float rows_above = (quarter_turn - source_top) * rows_per_radian;
    float rows_below = (quarter_turn + source_top) * rows_per_radian - float(source_size.y);
    inside = rows_above > 0.5 ? min(inside, position.y) : inside;
    inside = rows_below > 0.5 ? min(inside, to_end.y) : inside;
    return isnan(z) ? 1.0 : clamp(inside / MIXED_PX, 0.0, 1.0);
}

#ifdef FIND
layout(binding = 0) uniform usampler2DArray eye_origin;

void main() {
    ivec3 tile = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(tile.xy, tile_grid)))
        return;
    ivec2 first = tile.xy * TILE_SIDE, last = min(first + TILE_SIDE, textureSize(eye_origin, 0).xy) - 1;
    float least = 1.0;
    for (int k = 0; k < 4; ++k)
        least = min(least, share_of_window(ivec3(first + (last - first) * ivec2(k & 1, k >> 1), tile.z)));
    tile_states[tile_number(tile)] = least < 1.0 ? WITH_GAPS : NOT_THERE;
}
#else
bool listed_pixel(ivec2 size, out ivec3 at) {
    return listed_cell(1, TILE_SHIFT, at) && all(lessThan(at.xy, size));
}

#ifdef OPEN
layout(binding = 0) uniform usampler2DArray eye_origin;
layout(binding = 1, r8ui) uniform writeonly uimage2DArray mixed_origin;

void main() {
    ivec3 at;
    if (!listed_pixel(imageSize(mixed_origin).xy, at))
        return;
    // What others filled already shows what lies beyond the window.
    bool is_mixed = texelFetch(eye_origin, at, 0).x == ORIGIN_SOURCE && share_of_window(at) < 1.0;
    imageStore(mixed_origin, at, uvec4(is_mixed ? ORIGIN_GAP : ORIGIN_SOURCE));
}
#else
layout(binding = 0) uniform sampler2DArray base_colour;
layout(binding = 3) uniform usampler2DArray mixed_origin;
layout(binding = 0, rgba8) uniform image2DArray eye_colour;

void main() {
    ivec3 at;
    if (!listed_pixel(imageSize(eye_colour).xy, at) || texelFetch(mixed_origin, at, 0).x != ORIGIN_BASE)
        return;
    vec3 base = texelFetch(base_colour, at, 0).rgb, window = imageLoad(eye_colour, at).rgb;
    imageStore(eye_colour, at, vec4(mix(base, window, share_of_window(at)), 1.0));
}
#endif
#endif
