// Where directions fall among a source's samples: the formulas of conventions.h, as warp_positions-inl.h and look_up.h
// have them. Directions are in the source's frame; positions in samples, from the corner of the first.

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
// From look_up_vertex.glsl, where a fragment reads it: on the CPU a driver takes long for each word of a uniform block.
in GridConstants {
    GRID_MEMBERS(flat)
};
#else
layout(std140, binding = 0) uniform SourceGrid {
    GRID_MEMBERS()
};
#endif

float fast_atan2(float y, float x) {
    float ax = abs(x), ay = abs(y), larger = max(ax, ay);
    float a = larger > 0.0 ? min(ax, ay) / larger : larger;
    float s = a * a, p = 0.0;
    for (int i = 0; i < 8; ++i)
        p = p * s + ATAN_COEFFICIENTS[i];
    float angle = p * a;
    if (ay > ax)
        angle = HALF_PI - angle;
    if (x < 0.0)
        angle = PI - angle;
    return y < 0.0 ? -angle : angle;
}

/// Far outside where a flat picture does not look.
vec2 position_of(vec3 d) {
    vec2 half_size = 0.5 * vec2(source_size);
    if (source_is_sphere == 0) {
        float scale = source_focal_px / -d.z;
        return d.z < 0.0 ? vec2(d.x * scale + half_size.x, half_size.y - d.y * scale) : vec2(-1e9);
    }
    float longitude = fast_atan2(d.x, -d.z) - source_middle;
    longitude -= longitude > PI ? 2.0 * PI : 0.0;
    longitude += longitude < -PI ? 2.0 * PI : 0.0;
    float latitude = fast_atan2(d.y, sqrt(d.x * d.x + d.z * d.z));
    return vec2(longitude * columns_per_radian + half_size.x, (source_top - latitude) * rows_per_radian);
}

/// False for NaN.
bool is_covered(vec2 position) {
    return all(greaterThanEqual(position, vec2(-EDGE_ROUNDING_PX))) &&
           all(lessThanEqual(position, vec2(source_size) + vec2(EDGE_ROUNDING_PX)));
}

/// Beyond a pole the rows come back on the other side.
ivec2 over_pole(ivec2 s) {
    bool north = s.y < 0 && source_north_pole != 0, south = s.y >= source_size.y && source_south_pole != 0;
    return north || south ? ivec2(s.x + source_size.x / 2, north ? -1 - s.y : 2 * source_size.y - 1 - s.y) : s;
}

/// The sample that stands for one up to two samples beyond the edges: columns go round; beyond a pole the rows come back
/// on the other side; partial pictures repeat their edge.
ivec2 wrapped(ivec2 s) {
    s = over_pole(s);
    // Where columns go round: nothing is further out than once round, and dividing whole numbers is slow.
    int around = source_closes != 0 ? source_size.x : 0;
    s.x += s.x < 0 ? around : 0;
    s.x -= s.x >= source_size.x ? around : 0;
    return clamp(s, ivec2(0), source_size - 1);
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
