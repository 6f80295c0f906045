// Depths of the samples that a grid holds. Needs source_grid.glsl and a texture `source_depth`.
#include "gap_taps.glsl"

/// NaN where the grid has nothing, and beyond its rows: patches end anywhere.
float depth_around(ivec2 s) {
    s.x = column_round(source_wrapping(), s.x);
    ivec2 place;
    bool inside = all(greaterThanEqual(s, ivec2(0))) && all(lessThan(s, source_size));
    return inside && find_sample(s, place) ? texelFetch(source_depth, place, 0).x : UNKNOWN;
}
