// What gap pixels see where the eyes have no depth of their own: the surfaces of a grid's samples, drawn forward into
// the gaps (see forward_depth.cpp). An invocation has a sample: the cell to its right and below, and its footprint.
// Triangles are no larger than a sample or two, which are a few pixels.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 1) uniform sampler2D source_depth;
layout(binding = 3) uniform usampler2DArray eye_origin;

#include "gap_tiles.glsl"
#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "gap_samples.glsl"
#include "depth_clearance.glsl"
#include "forward_keys.glsl"

EyeRays eye;
int eye_number;
ivec2 eye_size;

/// A point in the eye's picture; `inverse` is 1 / planar depth, NaN for what is not before the eye.
struct Seen {
    vec2 at;
    float inverse;
};

Seen seen_at(ivec2 s, float distance_m) {
    vec3 point = (distance_m * direction_of(s) - eye.eye.xyz) * mat3(eye.source_from_eye);
    float ahead = -point.z;
    return Seen(eye.view.x * vec2(point.x, -point.y) / ahead + eye.view.yz + 0.5, ahead > 0.0 ? 1.0 / ahead : UNKNOWN);
}

// Of the samples around; reaches of those that are not there are not above 0.
float clearances[25];
Seen corners[9];  // of the nine in the middle

float clearance_at(ivec2 p) {
    return clearances[5 * (p.y + 2) + p.x + 2];
}

void look_around(ivec2 s) {
    for (int i = 0; i < 25; ++i) {
        ivec2 p = ivec2(i % 5, i / 5) - 2;
        float sample_m = depth_around(s + p);
        clearances[i] = sample_m > 0.0 ? clearance_of(sample_m) : -1.0;
        if (max(abs(p.x), abs(p.y)) > 1)
            continue;
        Seen seen = seen_at(s + p, min(sample_m, FAR_DISTANCE_M));
        corners[3 * (p.y + 1) + p.x + 1] = seen;
        if (isnan(seen.inverse))
            clearances[i] = -1.0;
    }
}

bool continues(float before, float p, float q) {
    return before > 0.0 && continues_line(before, p, q, box_radius_m, tolerance);
}

/// Neighbours of one surface: equal within the bound, or on a line with the sample before or after.
bool joined(ivec2 a, ivec2 step) {
    float p = clearance_at(a), q = clearance_at(a + step);
    return p > 0.0 && q > 0.0 &&
           (agree(p, q) || continues(clearance_at(a - step), p, q) || continues(clearance_at(a + 2 * step), q, p));
}

/// The tiles that a box of pixels' corners touches.
void tiles_of(vec2 low, vec2 high, out ivec2 from, out ivec2 to) {
    from = clamp(ivec2(floor(clamp(low, vec2(-1e6), vec2(1e6)))) >> TILE_SHIFT, ivec2(0), tile_grid);
    to = clamp(ivec2(floor(clamp(high, vec2(-1e6), vec2(1e6)))) >> TILE_SHIFT, ivec2(-1), tile_grid - 1);
}

bool touches_gaps(vec2 low, vec2 high) {
    ivec2 from, to;
    tiles_of(low, high, from, to);
    for (int row = from.y; row <= to.y; ++row)
        for (int column = from.x; column <= to.x; ++column)
            if (tile_state(ivec3(column, row, eye_number)) == WITH_GAPS)
                return true;
    return false;
}

void draw_triangle(Seen a, Seen b, Seen c, float sign_of_key) {
    vec2 ab = b.at - a.at, ac = c.at - a.at;
    float area = ab.x * ac.y - ac.x * ab.y;
    if (area == 0.0)
        return;
    vec2 low = min(a.at, min(b.at, c.at)), high = max(a.at, max(b.at, c.at));
    ivec2 from, to;
    tiles_of(low, high, from, to);
    for (int tile = 0; tile < (to.x - from.x + 1) * (to.y - from.y + 1); ++tile) {
        ivec2 of = from + ivec2(tile % (to.x - from.x + 1), tile / (to.x - from.x + 1));
        if (tile_state(ivec3(of, eye_number)) != WITH_GAPS)
            continue;
        ivec2 first = max(of * TILE_SIDE, ivec2(ceil(max(low - 0.5, vec2(0.0)))));
        ivec2 last = min(min(of * TILE_SIDE + TILE_SIDE, eye_size) - 1, ivec2(floor(min(high - 0.5, vec2(eye_size)))));
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x) {
                vec2 p = vec2(x, y) + 0.5 - a.at;
                float q = (p.x * ac.y - p.y * ac.x) / area, r = (p.y * ab.x - p.x * ab.y) / area;
                float inverse = a.inverse + q * (b.inverse - a.inverse) + r * (c.inverse - a.inverse);
                bool is_inside = q >= 0.0 && r >= 0.0 && q + r <= 1.0;
                if (is_inside && texelFetch(eye_origin, ivec3(x, y, eye_number), 0).x == ORIGIN_GAP)
                    give_key(ivec3(x, y, eye_number), sign_of_key * inverse);
            }
    }
}

/// What may belong to the sample: as far as its neighbours, at its own distance.
void draw_footprint(Seen footprint[4]) {
    for (int k = 0; k < 4; ++k)
        if (isnan(footprint[k].inverse))
            return;
    draw_triangle(footprint[0], footprint[1], footprint[3], -1.0);
    draw_triangle(footprint[0], footprint[3], footprint[2], -1.0);
}

void main() {
    ivec2 s = ivec2(gl_GlobalInvocationID.xy);
    eye_number = int(gl_GlobalInvocationID.z);
    if (any(greaterThanEqual(s, source_size)))
        return;
    eye = eyes[eye_number];
    eye_size = textureSize(eye_origin, 0).xy;
    box_radius_m = eye.agreement.x;
    tolerance = eye.agreement.y;
#ifdef PATCHES
    sphere_of_patches = patch_spheres[eye_number];
#endif
    float sample_m = depth_around(s);
    if (isnan(sample_m) || sample_m <= 0.0)
        return;
    sample_m = min(sample_m, FAR_DISTANCE_M);
    Seen own = seen_at(s, sample_m);
    if (isnan(own.inverse))
        return;
    // All that may be drawn lies between the corners of the footprint and of the cell.
    Seen footprint[4];
    vec2 low = own.at, high = own.at;
    for (int k = 0; k < 4; ++k) {
        footprint[k] = seen_at(s + 2 * ivec2(k & 1, k >> 1) - 1, sample_m);
        if (!isnan(footprint[k].inverse)) {
            low = min(low, footprint[k].at);
            high = max(high, footprint[k].at);
        }
        ivec2 next = s + ivec2(k & 1, k >> 1);
        float next_m = depth_around(next);
        Seen beside = seen_at(next, min(next_m, FAR_DISTANCE_M));
        if (next_m > 0.0 && !isnan(beside.inverse)) {
            low = min(low, beside.at);
            high = max(high, beside.at);
        }
    }
    if (!touches_gaps(low, high))
        return;
    look_around(s);
    const ivec2 RIGHT = ivec2(1, 0), DOWN = ivec2(0, 1);
    bool right = joined(ivec2(0), RIGHT), down = joined(ivec2(0), DOWN);
    bool far_right = joined(RIGHT, DOWN), far_down = joined(DOWN, RIGHT);
    if (right && far_right)
        draw_triangle(corners[4], corners[5], corners[8], 1.0);
    if (down && far_down)
        draw_triangle(corners[4], corners[8], corners[7], 1.0);
    bool surrounded = right && down && far_right && far_down;
    surrounded = surrounded && joined(-RIGHT, RIGHT) && joined(DOWN - RIGHT, RIGHT) && joined(-RIGHT, DOWN);
    surrounded = surrounded && joined(-DOWN, DOWN) && joined(RIGHT - DOWN, DOWN) && joined(-DOWN, RIGHT);
    surrounded = surrounded && joined(-RIGHT - DOWN, RIGHT) && joined(-RIGHT - DOWN, DOWN);
    if (!surrounded)
        draw_footprint(footprint);
}
