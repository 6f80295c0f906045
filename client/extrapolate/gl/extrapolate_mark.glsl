// Which region each pixel is of.
layout(local_size_x = PIECE) in;

layout(binding = 0, r8ui) uniform writeonly uimage2D region_map;

#include "extrapolate_regions.glsl"
#include "extrapolate_tiles.glsl"

void main() {
    ivec2 pixel;
    uint region;
    if (!find_pixel(pixel, region))
        return;
    imageStore(region_map, pixel, uvec4(region));
    mark_tile(pixel, MOVES);
}
