// The picture afterwards, in listed tiles, each a work group's: each pixel that something came to looks up what that was
// before, in its own region.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform sampler2D source_colour;
layout(binding = 1) uniform sampler2D source_depth;
layout(binding = 2) uniform usampler2D region_map;
layout(binding = 3) uniform sampler2D source_specular;
layout(binding = 4) uniform sampler2D source_virtual_depth;
layout(binding = 0, r32ui) uniform uimage2D candidates;
layout(binding = 1, rgba8) uniform writeonly image2D extrapolated_colour;
layout(binding = 2, r32f) uniform writeonly image2D extrapolated_depth;
layout(binding = 3, r8ui) uniform writeonly uimage2D extrapolated_map;
layout(binding = 4, r32f) uniform writeonly image2D extrapolated_specular;
layout(binding = 5, r32f) uniform writeonly image2D extrapolated_virtual_depth;

#include "extrapolate_regions.glsl"
#include "extrapolate_tiles.glsl"
#include "in_levels.glsl"

uniform int has_mask;  // what is specular; the textures above and below are there

struct Shown {
    vec3 colour;
    float depth_m;
    uint region;
    ivec2 was;       // of which sample
    float farther_m;  // by so much than there
};

/// Bilinear, of one region's pixels.
vec3 colour_before(vec2 position, uint region) {
    vec2 corner = floor(position - 0.5), part = position - 0.5 - corner;
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        ivec2 tap = ivec2(corner) + ivec2(k & 1, k >> 1);
        tap = clamp(ivec2(column_round(source_wrapping(), tap.x), tap.y), ivec2(0), source_size - 1);
        if (texelFetch(region_map, tap, 0).x != region)
            continue;
        float weight = ((k & 1) != 0 ? part.x : 1.0 - part.x) * ((k >> 1) != 0 ? part.y : 1.0 - part.y);
        sum += weight * vec4(texelFetch(source_colour, tap, 0).rgb, 1.0);
    }
    return sum.rgb / sum.a;
}

void show(ivec2 at, uint candidate, inout Shown shown) {
    uint region = region_of(candidate);
    Region way = regions[region - 1u];
    vec2 size = vec2(source_size);
    vec2 was = position_of(moved(way.backward, distance_of(candidate) * direction_of(at)));
    if (source_closes != 0)
        was.x -= size.x * floor(was.x / size.x);
    // A splat is wider than a pixel: only what was in the region is shown.
    if (!(all(greaterThanEqual(was, vec2(0.0))) && all(lessThan(was, size))) ||
        texelFetch(region_map, ivec2(was), 0).x != region)
        return;
    float before_m = region_depth(region, texelFetch(source_depth, ivec2(was), 0).x);
    float now_m = length(moved(way.forward, before_m * direction_at(was)));
    // What rests there and is nearer; infinity and NaN are not.
    if (shown.region == 0u && shown.depth_m <= now_m)
        return;
    shown = Shown(colour_before(was, region), now_m, region, ivec2(was), now_m - before_m);
}

void main() {
    uint i = gl_WorkGroupID.y * MAX_GROUPS_IN_ROW + gl_WorkGroupID.x;
    if (i >= listed)
        return;
    int tile = int(tiles[tile_count() + i]);
    ivec2 place = ivec2(tile % tile_grid().x, tile / tile_grid().x);
    ivec2 at = place * ivec2(GROUP_WIDTH, GROUP_HEIGHT) + ivec2(gl_LocalInvocationID);
    if (any(greaterThanEqual(at, source_size)))
        return;
    bool moves = texelFetch(region_map, at, 0).x != 0u;
    Shown shown = Shown(texelFetch(source_colour, at, 0).rgb, texelFetch(source_depth, at, 0).x, 0u, at, 0.0);
    if (moves)
        shown.depth_m = UNKNOWN;
    uint candidate = imageLoad(candidates, at).x;
    if (candidate != NO_CANDIDATE) {
        imageStore(candidates, at, uvec4(NO_CANDIDATE));
        show(at, candidate, shown);
    }
    imageStore(extrapolated_colour, at, vec4(in_levels(shown.colour), 1.0));
    imageStore(extrapolated_depth, at, vec4(shown.depth_m));
    imageStore(extrapolated_map, at, uvec4(shown.region));
    if (has_mask == 0)
        return;
    imageStore(extrapolated_specular, at, texelFetch(source_specular, shown.was, 0));
    imageStore(extrapolated_virtual_depth, at, texelFetch(source_virtual_depth, shown.was, 0) + shown.farther_m);
}
