// Where directions fall among a source's samples. Directions are in the source's frame; positions in samples, from the
// corner of the first.
#include "mapping.glsl.h"
#include "wrapping.glsl.h"

#define GRID_MEMBERS(each)         \
    each ivec2 source_size;        \
    each int source_is_sphere;     \
    each int source_closes;        \
    each int source_north_pole;    \
    each int source_south_pole;    \
    each float source_focal_px;    \
    each float source_middle;      \
    each float source_top;         \
    each float columns_per_radian; \
    each float rows_per_radian;

#ifdef GRID_BY_VERTEX
// From resample_vertex.glsl, where a fragment reads it: on the CPU a driver takes long for each word of a uniform block.
in GridConstants {
    GRID_MEMBERS(flat)
};
#else
layout(std140, binding = 0) uniform SourceGrid {
    GRID_MEMBERS()
};
#endif

ivec2 wrapped_within(Wrapping grid, ivec2 s) {
    return ivec2(wrapped_column(grid, s.x, s.y), wrapped_row(grid, s.y));
}

vec2 position_on(vec2 size, int is_sphere, float focal_px, float middle, float top, vec2 per_radian, vec3 d) {
    if (is_sphere == 0)
        return vec2(flat_column(d.x, d.z, focal_px, 0.5 * size.x), flat_row(d.y, d.z, focal_px, 0.5 * size.y));
    return vec2(sphere_column(d.x, d.z, middle, per_radian.x, 0.5 * size.x),
                sphere_row(d.x, d.y, d.z, top, per_radian.y));
}

vec2 position_of(vec3 d) {
    return position_on(vec2(source_size), source_is_sphere, source_focal_px, source_middle, source_top,
                       vec2(columns_per_radian, rows_per_radian), d);
}

#ifdef OTHER_GRID
// Of another picture.
layout(std140, binding = 2) uniform OtherGrid {
    GRID_MEMBERS()
} other;

/// Of a direction in that picture's frame.
vec2 position_in_other(vec3 d) {
    return position_on(vec2(other.source_size), other.source_is_sphere, other.source_focal_px, other.source_middle,
                       other.source_top, vec2(other.columns_per_radian, other.rows_per_radian), d);
}

/// The sample of that picture that stands for one up to two samples beyond its edges.
ivec2 wrapped_in_other(ivec2 s) {
    return wrapped_within(Wrapping(other.source_size.x, other.source_size.y, other.source_closes != 0,
                                   other.source_north_pole != 0, other.source_south_pole != 0),
                          s);
}
#endif

/// False for NaN.
bool is_covered(vec2 position) {
    return is_within(position.x, float(source_size.x)) && is_within(position.y, float(source_size.y));
}

Wrapping source_wrapping() {
    return Wrapping(source_size.x, source_size.y, source_closes != 0, source_north_pole != 0, source_south_pole != 0);
}

/// The sample that stands for one up to two samples beyond the edges.
ivec2 wrapped(ivec2 s) {
    return wrapped_within(source_wrapping(), s);
}

/// Unit directions of the centres of a sample and those right of it, below it and both; they may lie beyond the edges as
/// wrapped() has it. Few sines and cosines: beyond a pole those of the row alone come out on the other side.
vec3[4] directions_around(ivec2 corner) {
    ivec2 low = ivec2(source_closes != 0 ? -2 : 0, source_north_pole != 0 ? -2 : 0);
    ivec2 high = source_size + ivec2(source_closes != 0 ? 1 : -1, source_south_pole != 0 ? 1 : -1);
    vec2 first = vec2(clamp(corner, low, high)), second = vec2(clamp(corner + 1, low, high));
    vec2 x = vec2(first.x, second.x) + 0.5 - 0.5 * float(source_size.x), y = vec2(first.y, second.y) + 0.5;
    if (source_is_sphere == 0) {
        x /= source_focal_px;
        y = (0.5 * float(source_size.y) - y) / source_focal_px;
        return vec3[4](normalize(vec3(x.x, y.x, -1.0)), normalize(vec3(x.y, y.x, -1.0)),
                       normalize(vec3(x.x, y.y, -1.0)), normalize(vec3(x.y, y.y, -1.0)));
    }
    vec2 longitude = source_middle + x / columns_per_radian, latitude = source_top - y / rows_per_radian;
    vec2 right = sin(longitude), ahead = cos(longitude), level = cos(latitude), up = sin(latitude);
    return vec3[4](vec3(level.x * right.x, up.x, -level.x * ahead.x), vec3(level.x * right.y, up.x, -level.x * ahead.y),
                   vec3(level.y * right.x, up.y, -level.y * ahead.x),
                   vec3(level.y * right.y, up.y, -level.y * ahead.y));
}

/// Unit direction of a position.
vec3 direction_at(vec2 position) {
    vec2 from_middle = position - 0.5 * vec2(source_size);
    if (source_is_sphere == 0) {
        vec2 at = from_middle / source_focal_px;
        return normalize(vec3(at.x, -at.y, -1.0));
    }
    float longitude = source_middle + from_middle.x / columns_per_radian;
    float latitude = source_top - position.y / rows_per_radian;
    return vec3(cos(latitude) * sin(longitude), sin(latitude), -cos(latitude) * cos(longitude));
}

/// Unit direction of a sample's centre.
vec3 direction_of(ivec2 s) {
    return direction_at(vec2(s) + 0.5);
}
