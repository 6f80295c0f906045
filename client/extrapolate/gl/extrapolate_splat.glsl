// Which pixels the moving regions come to, nearest first: MovedRegion::splat.
layout(local_size_x = PIECE) in;

layout(binding = 0) uniform sampler2D source_depth;
layout(binding = 0, r32ui) uniform uimage2D candidates;

#include "extrapolate_regions.glsl"
#include "extrapolate_tiles.glsl"

/// Where what is seen at a position comes to: column, row, metres.
bool after(uint region, vec2 position, float before_m, out vec3 to) {
    vec3 point = moved(regions[region - 1u].forward, before_m * direction_at(position));
    to = vec3(position_of(point), length(point));
    return to.z > 0.0 && to.z < MAX_EXTRAPOLATED_M && all(lessThan(abs(to.xy), 4.0 * vec2(source_size)));
}

float column_difference(float difference) {
    float width = float(source_size.x);
    return source_closes != 0 ? difference - width * floor(difference / width + 0.5) : difference;
}

void main() {
    ivec2 pixel;
    uint region;
    if (!find_pixel(pixel, region))
        return;
    vec2 position = vec2(pixel) + 0.5;
    float before_m = region_depth(region, texelFetch(source_depth, pixel, 0).x);
    vec3 centre, aside;
    if (isnan(before_m) || before_m <= 0.0 || !after(region, position, before_m, centre))
        return;
    vec2 reach = vec2(0.5);
    for (int axis = 0; axis < 2; ++axis)
        if (after(region, position + vec2(1 - axis, axis), before_m, aside))
            reach += 0.5 * abs(vec2(column_difference(aside.x - centre.x), aside.y - centre.y));
    reach = min(reach, vec2(0.5 * float(source_size.x), MAX_HALF_HEIGHT));
    ivec2 low = ivec2(ceil(centre.xy - 0.5 - reach)), high = ivec2(floor(centre.xy - 0.5 + reach));
    uint candidate = candidate_of(centre.z, region);
    for (int y = max(low.y, 0); y <= min(high.y, source_size.y - 1); ++y)
        for (int x = low.x; x <= high.x; ++x) {
            int column = column_round(source_wrapping(), x);
            if (column >= 0 && column < source_size.x) {
                imageAtomicMin(candidates, ivec2(column, y), candidate);
                mark_tile(ivec2(column, y), REACHED);
            }
        }
}
