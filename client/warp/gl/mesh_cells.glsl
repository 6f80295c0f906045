// The cells of a source's mesh, as mesh.h has them; a group is a listed block. Of each block a quadtree is built from
// below: a node is flat if its four parts are and its two triangles hold all its points. Nodes whose parents are not
// flat are the cells. PLAIN: each cell of the lattice is one, whatever lies between its corners.
layout(local_size_x = 64) in;

#define BUILDS
#include "source_grid.glsl"
#include "source_lattice.glsl"
#include "mesh_lists.glsl"

uniform vec2 joins;  // box radius in metres, sin e, of what is one surface
uniform float share; // sine of what cells may be off by

const int MARGIN = 1, STRIDE = SIDE + 4;
const int NODES = (4 * SIDE * SIDE - 1) / 3, MESH_LEVELS = BLOCK_LEVELS;

shared float k_of[STRIDE * STRIDE];  // of points from (-1, -1) on
shared vec2 columns[POINTS], rows[POINTS];  // what directions are made of
shared uint flat_nodes[NODES];
shared vec3 upper_planes[SIDE * SIDE / 4], lower_planes[SIDE * SIDE / 4];  // of the nodes of one level
shared uint has_flat[MESH_LEVELS + 1];  // by level
shared uint own_corners[CORNER_WORDS];

int k_at(ivec2 p) {
    return (p.y + MARGIN) * STRIDE + p.x + MARGIN;
}

bool joined(ivec2 p, ivec2 step) {
    int i = k_at(p), d = step.y * STRIDE + step.x;
    return are_joined(k_of[i - d], k_of[i], k_of[i + d], k_of[i + 2 * d]);
}

vec3 q_of(ivec2 p) {
    return direction_of_angles(columns[p.x], rows[p.y]);
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

/// Row j of both triangles of a node, split from its first corner to the opposite one, where both hold.
bool row_holds(ivec2 first, int size, int j, int node) {
    vec3 lower = lower_planes[node], upper = upper_planes[node];
    vec2 row = rows[first.y + j];
    int at = k_at(first + ivec2(0, j));
    bool good = true;
    for (int i = 0; i <= size + 1; ++i) {
        int x = i <= j ? i : i - 1;
        vec3 q = direction_of_angles(columns[first.x + x], row);
        good = good && same_inverse(dot(i <= j ? lower : upper, q), k_of[at + x]);
    }
    return good;
}

/// Whether any node of the level is flat. Planes are found once a node, all rows of all nodes looked through at once.
bool build(int level, ivec2 cells) {
    // Shifts, for dividing whole numbers is slow.
    int size = 1 << level, across_bits = MESH_LEVELS - level, last = (1 << across_bits) - 1;
    int nodes = 1 << (2 * across_bits);
    for (int i = int(gl_LocalInvocationIndex); i < nodes; i += 64) {
        ivec2 n = ivec2(i & last, i >> across_bits), first = n * size, opposite = first + size;
        bool parts = all(lessThanEqual(opposite, cells));
        for (int k = 0; k < 4; ++k)
            parts = parts && flat_nodes[node_of(level - 1, 2 * n + ivec2(k & 1, k >> 1))] != 0u;
        if (parts) {
            upper_planes[i] = plane_through(first, ivec2(opposite.x, first.y), opposite);
            lower_planes[i] = plane_through(first, opposite, ivec2(first.x, opposite.y));
            flat_nodes[node_of(level, n)] = 1u;
            has_flat[level] = 1u;
        }
    }
    barrier();
    if (has_flat[level] == 0u)
        return false;
    for (int i = int(gl_LocalInvocationIndex); i < nodes * (size + 1); i += 64) {
        int of = i & (nodes - 1);
        ivec2 n = ivec2(of & last, of >> across_bits);
        if (flat_nodes[node_of(level, n)] != 0u && !row_holds(n * size, size, i >> (2 * across_bits), of))
            flat_nodes[node_of(level, n)] = 0u;
    }
    barrier();
    return true;
}

void load(ivec2 origin, ivec2 cells) {
    int own = int(gl_LocalInvocationIndex);
    for (int i = own; i < STRIDE * STRIDE; i += 64)
        k_of[i] = lattice_inverse(origin + ivec2(i % STRIDE, i / STRIDE) - MARGIN);
    for (int i = own; i < POINTS; i += 64) {
        columns[i] = column_angles(origin.x + i);
        rows[i] = row_angles(origin.y + i);
    }
    for (int i = own; i < NODES; i += 64)
        flat_nodes[i] = 0u;
    if (own <= MESH_LEVELS)
        has_flat[own] = 0u;
    barrier();
}

void find_flat_cells(ivec2 cells) {
    for (int i = int(gl_LocalInvocationIndex); i < SIDE * SIDE; i += 64) {
        ivec2 p = ivec2(i % SIDE, i / SIDE);
        if (all(lessThan(p, cells)) && joined(p, ivec2(1, 0)) && joined(p + ivec2(0, 1), ivec2(1, 0)) &&
            joined(p, ivec2(0, 1)) && joined(p + ivec2(1, 0), ivec2(0, 1)))
            flat_nodes[node_of(0, p)] = 1u;
    }
    barrier();
}

uint cut_cell(ivec2 p) {
    return CUT | (joined(p, ivec2(1, 0)) ? 0x10u : 0u) | (joined(p + ivec2(1, 0), ivec2(0, 1)) ? 0x20u : 0u) |
           (joined(p + ivec2(0, 1), ivec2(1, 0)) ? 0x40u : 0u) | (joined(p, ivec2(0, 1)) ? 0x80u : 0u);
}

void mark_corner(ivec2 p) {
    if (p.x < SIDE)
        atomicOr(own_corners[p.y], 1u << p.x);
    else
        atomicOr(own_corners[POINTS + (p.y >> 5)], 1u << (p.y & 31));
}

/// Splits it as mesh_points.glsl does; what hangs on an unknown corner is left out.
uint plain_cell(ivec2 p) {
    bool known = k_of[k_at(p)] >= 0.0 && k_of[k_at(p + 1)] >= 0.0;
    bool upper = known && k_of[k_at(p + ivec2(1, 0))] >= 0.0, lower = known && k_of[k_at(p + ivec2(0, 1))] >= 0.0;
    return upper && lower ? 1u : upper ? UPPER : lower ? LOWER : 0u;
}

/// 0 where none begins.
uint cell_at(ivec2 p, out int side) {
    side = 1;
#ifdef PLAIN
    return plain_cell(p);
#else
    int flat_levels = 0;
    while (flat_levels <= MESH_LEVELS && flat_nodes[node_of(flat_levels, p >> flat_levels)] != 0u)
        ++flat_levels;
    side = 1 << max(flat_levels - 1, 0);
    if (any(notEqual(p & (side - 1), ivec2(0))))
        return 0u;
    return flat_levels == 0 ? cut_cell(p) : uint(flat_levels);
#endif
}

void build_block(uint block) {
    ivec2 origin = block_origin(block_place(block)), cells = cells_in_block(block_place(block));
    int own = int(gl_LocalInvocationIndex);
    if (own < CORNER_WORDS)
        own_corners[own] = 0u;
    tolerance = joins.y;
    load(origin, cells);
#ifndef PLAIN
    find_flat_cells(cells);
    tolerance = share;
    for (int level = 1; level <= MESH_LEVELS; ++level)
        if (!build(level, cells))
            break;
    tolerance = joins.y;
#endif
    for (int i = own; i < SIDE * SIDE; i += 64) {
        ivec2 p = ivec2(i % SIDE, i / SIDE);
        if (any(greaterThanEqual(p, cells)))
            continue;
        int side;
        uint cell = cell_at(p, side);
        imageStore(mesh_cells, origin + p + 1, uvec4(cell));
        if (cell != 0u)
            for (int k = 0; k < 4; ++k)
                mark_corner(p + ivec2(k & 1, k >> 1) * side);
    }
    barrier();
    if (own < CORNER_WORDS)
        corners[int(block) * CORNER_WORDS + own] = own_corners[own];
}

void main() {
    box_radius_m = joins.x;
    uint block;
    if (find_listed(CELLS, block))
        build_block(block);
}
