// The cells of a source's mesh, as mesh_cells.h has them; a group is a block. Of each block a quadtree is built from
// below: a node is flat if its four parts are and its two triangles hold all its points. Nodes whose parents are not
// flat are the cells.
layout(local_size_x = 256) in;

#define BUILDS
#include "source_grid.glsl"
#include "mesh_lattice.glsl"
#include "mesh_lists.glsl"

uniform vec2 joins;  // box radius in metres, sin e, of what is one surface
uniform float share; // sine of what cells may be off by

const int LEVELS = 5, SIDE = 1 << LEVELS, POINTS = SIDE + 1, MARGIN = 1, STRIDE = SIDE + 4;
const int NODES = (4 * SIDE * SIDE - 1) / 3;

shared float k_of[STRIDE * STRIDE];  // of points from (-1, -1) on
shared float qx[POINTS * POINTS], qy[POINTS * POINTS], qz[POINTS * POINTS];
shared uint flat_nodes[NODES];

int k_at(ivec2 p) {
    return (p.y + MARGIN) * STRIDE + p.x + MARGIN;
}

bool joined(ivec2 p, ivec2 step) {
    int i = k_at(p), d = step.y * STRIDE + step.x;
    return are_joined(k_of[i - d], k_of[i], k_of[i + d], k_of[i + 2 * d]);
}

vec3 q_of(ivec2 p) {
    int i = p.y * POINTS + p.x;
    return vec3(qx[i], qy[i], qz[i]);
}

/// Where a level's nodes begin; they stand row by row.
int node_of(int level, ivec2 n) {
    int before = NODES - (4 * (SIDE >> level) * (SIDE >> level) - 1) / 3;
    return before + n.y * (SIDE >> level) + n.x;
}

/// m of 1/r = m . q through three points: m = k q_a / |q_a|^2 + s u + t v is right at a because u and v are square to
/// q_a, at b and c by the choice of s and t. In double precision: the points lie close together.
vec3 plane_through(ivec2 a, ivec2 b, ivec2 c) {
    dvec3 origin = dvec3(q_of(a));
    double square = dot(origin, origin), k_a = double(k_of[k_at(a)]), k = k_a / square;
    dvec3 to_b = dvec3(q_of(b)) - origin, to_c = dvec3(q_of(c)) - origin;
    dvec3 u = to_b - dot(to_b, origin) / square * origin, v = to_c - dot(to_c, origin) / square * origin;
    double at_u = double(k_of[k_at(b)]) - k_a - k * dot(origin, to_b);
    double at_v = double(k_of[k_at(c)]) - k_a - k * dot(origin, to_c);
    double uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), determinant = uu * vv - uv * uv;
    double s = (at_u * vv - at_v * uv) / determinant, t = (at_v * uu - at_u * uv) / determinant;
    return vec3(k * origin + s * u + t * v);
}

bool row_holds(ivec2 first, int last_x, vec3 plane) {
    bool good = true;
    for (ivec2 p = first; p.x <= last_x; ++p.x)
        good = good && same_inverse(dot(plane, q_of(p)), k_of[k_at(p)]);
    return good;
}

/// Row j of both triangles of a cell, split from its first corner to the opposite one.
bool holds(ivec2 first, int size, int j) {
    ivec2 opposite = first + size;
    vec3 upper = plane_through(first, ivec2(opposite.x, first.y), opposite);
    vec3 lower = plane_through(first, opposite, ivec2(first.x, opposite.y));
    return row_holds(first + ivec2(0, j), first.x + j, lower) && row_holds(first + ivec2(j, j), opposite.x, upper);
}

void build(int level, ivec2 cells) {
    int size = 1 << level, across = SIDE >> level;
    for (int i = int(gl_LocalInvocationIndex); i < across * across; i += 256) {
        ivec2 n = ivec2(i % across, i / across);
        bool parts = all(lessThanEqual((n + 1) * size, cells));
        for (int k = 0; k < 4; ++k)
            parts = parts && flat_nodes[node_of(level - 1, 2 * n + ivec2(k & 1, k >> 1))] != 0u;
        flat_nodes[node_of(level, n)] = parts ? 1u : 0u;
    }
    barrier();
    for (int i = int(gl_LocalInvocationIndex); i < across * across * (size + 1); i += 256) {
        ivec2 n = ivec2(i % across, i / across % across);
        int node = node_of(level, n);
        if (flat_nodes[node] != 0u && !holds(n * size, size, i / (across * across)))
            atomicAnd(flat_nodes[node], 0u);
    }
    barrier();
}

void load(ivec2 origin, ivec2 cells) {
    for (int i = int(gl_LocalInvocationIndex); i < STRIDE * STRIDE; i += 256)
        k_of[i] = lattice_inverse(origin + ivec2(i % STRIDE, i / STRIDE) - MARGIN);
    for (int i = int(gl_LocalInvocationIndex); i < POINTS * POINTS; i += 256) {
        vec3 q = lattice_direction(origin + ivec2(i % POINTS, i / POINTS));
        qx[i] = q.x;
        qy[i] = q.y;
        qz[i] = q.z;
    }
    barrier();
    box_radius_m = joins.x;
    tolerance = joins.y;
    for (int i = int(gl_LocalInvocationIndex); i < SIDE * SIDE; i += 256) {
        ivec2 p = ivec2(i % SIDE, i / SIDE);
        bool whole = all(lessThan(p, cells)) && joined(p, ivec2(1, 0)) && joined(p + ivec2(0, 1), ivec2(1, 0)) &&
                     joined(p, ivec2(0, 1)) && joined(p + ivec2(1, 0), ivec2(0, 1));
        flat_nodes[node_of(0, p)] = whole ? 1u : 0u;
    }
    barrier();
}

void give(ivec2 first, ivec2 in_block, int level, bool whole) {
    for (int k = 0; k < 4; ++k)
        imageStore(cell_corners, corner_place(first + (ivec2(k & 1, k >> 1) << level)), uvec4(1u));
    if (!whole) {
        uint with_next = (joined(in_block, ivec2(1, 0)) ? 1u : 0u) |
                         (joined(in_block + ivec2(1, 0), ivec2(0, 1)) ? 2u : 0u) |
                         (joined(in_block + ivec2(0, 1), ivec2(1, 0)) ? 4u : 0u) |
                         (joined(in_block, ivec2(0, 1)) ? 8u : 0u);
        cuts[appended(CUTS)] = packed_cell(first, with_next);
    } else if (level == 0) {
        quads[appended(QUADS)] = packed_cell(first, 0u);
    } else {
        uint before = atomicAdd(large_count, 1u);
        large_cells[before] = packed_cell(first, uint(level));
        if ((before & 255u) == 0u)
            atomicAdd(large_groups[0], 1u);
    }
}

void main() {
    ivec2 first_of_all = ivec2(source_closes != 0 ? 0 : -1, -1);
    ivec2 origin = first_of_all + ivec2(gl_WorkGroupID.xy) * SIDE;
    ivec2 cells = min(ivec2(SIDE), source_size - origin);
    load(origin, cells);
    tolerance = share;
    for (int level = 1; level <= LEVELS; ++level)
        build(level, cells);
    tolerance = joins.y;
    for (int level = 0; level <= LEVELS; ++level) {
        int across = SIDE >> level;
        for (int i = int(gl_LocalInvocationIndex); i < across * across; i += 256) {
            ivec2 n = ivec2(i % across, i / across), in_block = n << level;
            bool whole = flat_nodes[node_of(level, n)] != 0u, within = all(lessThan(in_block, cells));
            bool in_larger = level < LEVELS && flat_nodes[node_of(level + 1, n / 2)] != 0u;
            if (within && !in_larger && (whole || level == 0))
                give(origin + in_block, in_block, level, whole);
        }
    }
}
