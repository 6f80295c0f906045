// Vertices of a mesh's triangles (mesh_lists.glsl) as each eye sees them, an instance for each. Depth is near / planar
// depth: linear on the screen along a plane.
#extension GL_ARB_shader_viewport_layer_array : require

uniform int list;
uniform vec2 eye_size;
uniform vec2 joins;  // as in mesh_cells.glsl

out float point_inverse;      // k: its perspective interpolation over the point's planar depth is 1 / planar depth
flat out int is_either_way;  // cells over a pole are turned over: which way round they come says nothing

#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "mesh_lattice.glsl"
#include "mesh_lists.glsl"

struct Point {
    vec3 q;
    float k;
};

Point lattice_point(ivec2 p) {
    return Point(lattice_direction(p), lattice_inverse(p));
}

/// How k goes on along an axis from a point, towards or against it, where the surface does.
float slope(ivec2 p, ivec2 step, float towards) {
    float k[5];
    for (int i = 0; i < 5; ++i)
        k[i] = lattice_inverse(p + (i - 2) * step);
    bool before = are_joined(k[0], k[1], k[2], k[3]), after = are_joined(k[1], k[2], k[3], k[4]);
    if (after && (towards > 0.0 || !before))
        return k[3] - k[2];
    return before ? k[2] - k[1] : 0.0;
}

/// The inverse distance that a point's own surface has a little beside it.
float continued(ivec2 p, vec2 by) {
    return lattice_inverse(p) + by.x * slope(p, ivec2(1, 0), by.x) + by.y * slope(p, ivec2(0, 1), by.y);
}

const ivec2 CORNERS[4] = ivec2[4](ivec2(0, 0), ivec2(1, 0), ivec2(1, 1), ivec2(0, 1));

/// Halfway from one point to the next: what is joined meets there, what is not goes on along its own plane.
Point towards(ivec2 p, ivec2 to, bool joined) {
    Point a = lattice_point(p), b = lattice_point(to);
    float k = joined ? 0.5 * (a.k + b.k) : max(continued(p, 0.5 * vec2(to - p)), 0.0);
    return Point(0.5 * (a.q + b.q), k);
}

/// The middle of a cut cell, at the mean of what corner i and those that it is joined to have there.
Point middle(ivec2 first, uint with_next, int i) {
    // Corners that are joined, directly or by others, are numbered alike.
    ivec4 part = ivec4(0, 1, 2, 3);
    for (int j = 0; j < 4; ++j)
        if ((with_next >> j & 1u) != 0u) {
            int from = part[(j + 1) & 3], to = part[j];
            for (int l = 0; l < 4; ++l)
                part[l] = part[l] == from ? to : part[l];
        }
    vec3 q = vec3(0.0);
    float sum = 0.0, count = 0.0;
    for (int j = 0; j < 4; ++j) {
        ivec2 p = first + CORNERS[j];
        q += 0.25 * lattice_direction(p);
        if (part[j] == part[i]) {
            sum += continued(p, 0.5 - vec2(CORNERS[j]));
            count += 1.0;
        }
    }
    return Point(q, max(sum / count, 0.0));
}

/// Each corner has the quarter next to it: two triangles.
Point cut_point(uint cell, int vertex) {
    ivec2 first = first_corner(cell);
    uint with_next = cell >> 28;
    int i = vertex / 6, of = vertex % 6, next = (i + 1) & 3, last = (i + 3) & 3;
    ivec2 here = first + CORNERS[i];
    if (!(lattice_inverse(here) >= 0.0))
        return Point(vec3(0.0), UNKNOWN);
    if (of == 0 || of == 3)
        return lattice_point(here);
    if (of == 1)
        return towards(here, first + CORNERS[next], (with_next >> i & 1u) != 0u);
    if (of == 5)
        return towards(here, first + CORNERS[last], (with_next >> last & 1u) != 0u);
    return middle(first, with_next, i);
}

Point fan_point(uvec2 fan, int vertex) {
    ivec2 first = first_corner(fan.x);
    int side = 1 << int(fan.x >> 28);
    return lattice_point(first + (vertex == 0   ? ivec2(side / 2)
                                  : vertex == 1 ? on_border(int(fan.y & 0xffffu), side)
                                                : on_border(int(fan.y >> 16), side)));
}

Point quad_point(uint cell, int vertex) {
    const int corners[6] = int[6](0, 1, 2, 0, 2, 3);
    return lattice_point(first_corner(cell) + (CORNERS[corners[vertex]] << int(cell >> 28)));
}

void main() {
    EyeRays eye = eyes[gl_InstanceID];
    box_radius_m = joins.x;
    tolerance = joins.y;
    uint entry = uint(gl_VertexID) / VERTICES[list];
    int vertex = gl_VertexID % int(VERTICES[list]);
    uint cell = list == int(QUADS) ? quads[entry] : list == int(FANS) ? fans[entry].x : cuts[entry];
    Point p = list == int(QUADS)  ? quad_point(cell, vertex)
              : list == int(FANS) ? fan_point(fans[entry], vertex)
                                  : cut_point(cell, vertex);
    vec3 seen = (p.q - p.k * eye.eye.xyz) * mat3(eye.source_from_eye);
    float ahead = -seen.z;
    vec2 across = eye.view.x * vec2(seen.x, -seen.y) + (eye.view.yz + 0.5) * ahead;
    gl_Position = vec4(2.0 * across / eye_size - ahead, NEAR_PLANE_M * p.k, ahead);
    if (isnan(p.k))
        gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
    gl_Layer = gl_InstanceID;
    point_inverse = p.k;
    is_either_way = first_corner(cell).y < 0 ? 1 : 0;
}
