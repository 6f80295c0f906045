// A source's depth as a surface (see source_lattice.h): points (q, k) of columns from -1 to its width and rows from
// -1 to its height. Needs source_grid.glsl.

#include "depth_clearance.glsl"

layout(binding = 1) uniform sampler2D source_depth;
layout(binding = 5) uniform sampler2D lattice_angles;  // of columns, and in the second row of rows; from -1 on

/// Brings a sphere's points back into the picture.
ivec2 lattice_wrapped(ivec2 p) {
    Wrapping grid = source_wrapping();
    int x = column_round(grid, column_over_pole(grid, p.x, p.y));
    // Nothing is further out than a block.
    return ivec2(column_round(grid, x), row_over_pole(grid, p.y));
}

float inverse_of_sample(ivec2 s) {
    float distance_m = texelFetch(source_depth, s, 0).x;
    return distance_m > 0.0 ? 1.0 / distance_m : UNKNOWN;
}

/// Whether it is a sample's place, once round a sphere or over its poles.
bool is_sample(ivec2 p) {
    p = lattice_wrapped(p);
    return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, source_size));
}

/// k: on the picture's edge, half a pixel beyond a sample, where its plane leads; NaN further out.
float lattice_inverse(ivec2 p) {
    p = lattice_wrapped(p);
    ivec2 inner = clamp(p, ivec2(0), source_size - 1);
    if (p == inner)
        return inverse_of_sample(p);
    if (any(lessThan(p, ivec2(-1))) || any(greaterThan(p, source_size)))
        return UNKNOWN;
    float behind = inverse_of_sample(clamp(2 * inner - p, ivec2(0), source_size - 1));
    float k = 1.5 * inverse_of_sample(inner) - 0.5 * behind;
    return isnan(k) ? UNKNOWN : max(k, 0.0);
}

/// What directions are made of, of any column and row of the lattice: a sphere's row beyond a pole goes on over it, so
/// that cosines of latitude are negative there.
vec2 column_angles(int x) {
    x = source_closes != 0 ? lattice_wrapped(ivec2(x, 0)).x : clamp(x, -1, source_size.x);
    return texelFetch(lattice_angles, ivec2(x + 1, 0), 0).xy;
}

vec2 row_angles(int y) {
    Wrapping grid = source_wrapping();
    int of = clamp(row_over_pole(grid, y), -1, source_size.y);
    vec2 row = texelFetch(lattice_angles, ivec2(of + 1, 1), 0).xy;
    return is_beyond_pole(grid, y) ? vec2(row.x, -row.y) : row;
}

vec3 direction_of_angles(vec2 column, vec2 row) {
    if (source_is_sphere == 0)
        return vec3(column.x, row.x, -1.0) * inversesqrt(1.0 + column.x * column.x + row.x * row.x);
    return vec3(row.y * column.x, row.x, -row.y * column.y);
}

/// Of a point beyond a pole, its sample's own: of an odd number of columns none lies right opposite.
vec3 lattice_direction(ivec2 p) {
    p = clamp(lattice_wrapped(p), ivec2(-1), source_size) + 1;
    return direction_of_angles(texelFetch(lattice_angles, ivec2(p.x, 0), 0).xy, texelFetch(lattice_angles, ivec2(p.y, 1), 0).xy);
}
