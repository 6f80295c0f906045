// Where eyes see the border of the window that their source is, as WindowBorder of base_pass.cpp has it. With FIND the
// tiles there are found. Else the eyes' pictures take from what they see of the sphere around alone: gaps, most of
// which lie beyond the border, and a share along it. Tiles whose corners all lie well within the window are passed
// over: where no border is in view nothing is done but to look at those. The CPU cannot tell by the eyes' frustums, for
// it knows of no depth.
#ifdef FIND
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;
#else
layout(local_size_x = 256) in;
#endif

layout(binding = 0) uniform usampler2DArray eye_origin;
layout(binding = 2) uniform sampler2DArray eye_depth;

#include "gap_tiles.glsl"

uniform float inverse_depth_scale;  // of its samples; 0: what is seen is known by direction alone

#include "window_share.glsl"

#ifdef FIND
uniform int knows_gaps;  // 1: eye_depth is also that of gaps; 0: what it has there is of no use

void main() {
    ivec3 tile = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(tile.xy, tile_grid)))
        return;
    ivec2 first = tile.xy * TILE_SIDE, last = min(first + TILE_SIDE, textureSize(eye_origin, 0).xy) - 1;
    float least = 1.0;
    for (int k = 0; k < 4; ++k) {
        ivec3 at = ivec3(first + (last - first) * ivec2(k & 1, k >> 1), tile.z);
        bool is_known = knows_gaps != 0 || texelFetch(eye_origin, at, 0).x != ORIGIN_GAP;
        float z = is_known ? known(inverse_depth_scale, texelFetch(eye_depth, at, 0).x) : 0.0;
        least = min(least, share_of_window(position_in_window(at, z)));
    }
    tile_states[tile_number(tile)] = least < 1.0 ? WITH_GAPS : NOT_THERE;
}
#else
#include "mirror_planes.glsl"

layout(binding = 1) uniform sampler2DArray base_colour;
layout(binding = 3) uniform usampler2DArray base_origin;
layout(binding = 4) uniform sampler2DArray base_depth;
layout(binding = 0, rgba8) uniform image2DArray eye_colour;
layout(binding = 1, r8ui) uniform writeonly uimage2DArray filled_origin;  // the same as eye_origin
layout(binding = 2, r32f) uniform writeonly image2DArray filled_depth;    // the same as eye_depth

uniform float base_depth_scale;  // as inverse_depth_scale
uniform int fills_gaps;          // 1: gaps; 0: what the window coloured, and not alone
uniform int finds_depth;         // 1: with a gap's colour its depth is taken over
uniform int knows_mirrors;       // 1: the window has a mask of them

void main() {
    ivec3 at;
    if (!listed_cell(1, TILE_SHIFT, at) || any(greaterThanEqual(at.xy, imageSize(eye_colour).xy)) ||
        texelFetch(base_origin, at, 0).x != ORIGIN_SOURCE)
        return;
    vec3 base = texelFetch(base_colour, at, 0).rgb;
    if (texelFetch(eye_origin, at, 0).x != (fills_gaps != 0 ? ORIGIN_GAP : ORIGIN_SOURCE))
        return;
    if (fills_gaps == 0) {
        float z = known(inverse_depth_scale, texelFetch(eye_depth, at, 0).x);
        float share = share_of_window(position_in_window(at, z));
        if (share < 1.0)
            imageStore(eye_colour, at, vec4(mixed(base, imageLoad(eye_colour, at).rgb, share), 1.0));
        return;
    }
    float z = texelFetch(base_depth, at, 0).x;
    vec2 position = position_in_window(at, known(base_depth_scale, z));
    // What mirrors of the window show is not on them.
    if (knows_mirrors != 0 && is_covered(position) && is_specular(clamp(ivec2(position), ivec2(0), source_size - 1)))
        return;
    imageStore(eye_colour, at, vec4(base, 1.0));
    imageStore(filled_origin, at, uvec4(ORIGIN_BASE));
    if (finds_depth != 0)
        imageStore(filled_depth, at, vec4(base_depth_scale == 0.0 ? UNKNOWN : z));
}
#endif
