// Points and triangles of a mesh's cells (mesh_cells.glsl), as mesh.h has them; a group is a listed block, an
// invocation a row of it. Cells larger than one of the lattice become two triangles, or, where smaller ones end on
// their border, a fan around their middle, so that no crack opens. Points of blocks that there is no room for are counted.
layout(local_size_x = 64) in;

#define BUILDS
#include "source_grid.glsl"
#include "source_lattice.glsl"
#include "mesh_lists.glsl"

uniform vec2 joins;  // as in mesh_cells.glsl

layout(std430, binding = 5) writeonly buffer MeshPoints {
    vec4 points[];  // (q, k)
};
layout(std430, binding = 6) writeonly buffer MeshIndices {
    uint indices[];
};

const int MARGIN = 2, STRIDE = SIDE + 5;
const uint CUT_POINTS = 12u;  // of a cut cell beside its corners, at most

shared float k_of[STRIDE * STRIDE];  // of points from (-2, -2) on
// A bit for each point of a row that is a cell's corner, the last one's apart; how many points come before a row's.
shared uint corner_bits[POINTS], last_bits[POINTS], points_before[POINTS + 1];
// Of rows of cells: further points and indices, then how many come before a row's.
shared uint further_points[SIDE + 1], row_indices[SIDE + 1];
shared uint first_point, first_index;

uint own_block;
ivec2 origin;

int k_at(ivec2 p) {
    return (p.y + MARGIN) * STRIDE + p.x + MARGIN;
}

bool is_corner(ivec2 p) {
    return (p.x == SIDE ? last_bits[p.y] : corner_bits[p.y] >> p.x & 1u) != 0u;
}

/// Where a corner stands among the block's points.
uint corner_number(ivec2 p) {
    uint before = p.x == SIDE ? corner_bits[p.y] : corner_bits[p.y] & ((1u << p.x) - 1u);
    return points_before[p.y] + uint(bitCount(before));
}

uint cell_at(ivec2 p) {
    return imageLoad(mesh_cells, origin + p + 1).x;
}

/// Place on the border of a cell whose side is 1 << level, clockwise from its first corner.
ivec2 on_border(int place, int level) {
    int side = 1 << level, edge = place >> level, along = place & (side - 1);
    return edge == 0   ? ivec2(along, 0)
           : edge == 1 ? ivec2(side, along)
           : edge == 2 ? ivec2(side - along, side)
           : edge == 3 ? ivec2(0, side - along)
                       : ivec2(0);
}

int corners_on_border(ivec2 first, int level) {
    if (level == 0)
        return 4;
    int corners = 0;
    for (int place = 0; place < 4 << level; ++place)
        corners += is_corner(first + on_border(place, level)) ? 1 : 0;
    return corners;
}

const ivec2 CORNERS[4] = ivec2[4](ivec2(0, 0), ivec2(1, 0), ivec2(1, 1), ivec2(0, 1));

/// Points beside corners, and triangles.
uvec2 counts_of(ivec2 p, uint cell) {
    uint kind = cell & 0xfu;
    if (kind == 0u)
        return uvec2(0u);
    if (kind == CUT) {
        uint triangles = 0u;
        for (int i = 0; i < 4; ++i)
            triangles += k_of[k_at(p + CORNERS[i])] >= 0.0 ? 2u : 0u;
        return uvec2(triangles > 0u ? CUT_POINTS : 0u, triangles);
    }
    if (kind > CUT)
        return uvec2(0u, 1u);
    int corners = corners_on_border(p, int(kind - 1u));
    return corners == 4 ? uvec2(0u, 2u) : uvec2(1u, uint(corners));
}

/// Cells over a pole are turned over: which way round they come says nothing, and they are drawn both ways.
uint ways_round(ivec2 p) {
    return origin.y + p.y < 0 ? 2u : 1u;
}

uint next_index;

void add_triangle(ivec2 p, uint a, uint b, uint c) {
    uint in_block = first_point;
    indices[next_index++] = in_block + a;
    indices[next_index++] = in_block + b;
    indices[next_index++] = in_block + c;
    if (ways_round(p) == 2u) {
        indices[next_index++] = in_block + a;
        indices[next_index++] = in_block + c;
        indices[next_index++] = in_block + b;
    }
}

void put_point(uint number, vec3 q, float k) {
    points[first_point + number] = vec4(q, k);
}

/// How k goes on along an axis from a point, towards or against it, where the surface does.
float slope(ivec2 p, ivec2 step, float towards) {
    int at = k_at(p), d = step.y * STRIDE + step.x;
    float k[5];
    for (int i = 0; i < 5; ++i)
        k[i] = k_of[at + (i - 2) * d];
    bool before = are_joined(k[0], k[1], k[2], k[3]), after = are_joined(k[1], k[2], k[3], k[4]);
    if (after && (towards > 0.0 || !before))
        return k[3] - k[2];
    return before ? k[2] - k[1] : 0.0;
}

/// Each corner has the quarter next to it; what is joined meets in common points, what is not goes on along its own
/// plane up to the middle and ends there. Further points: in the middle one for each part, numbered as its first corner;
/// from 4 on on corner i's way to the next, from 8 on on its way to the one before, where not joined.
void add_cut(ivec2 p, uint with_next, uint first_further) {
    vec3 q[4], middle = vec3(0.0);
    vec2 half_steps[4];  // of k, along each axis into the cell
    float k[4], sums[4], counts[4];
    ivec4 part = ivec4(0, 1, 2, 3);
    for (int i = 0; i < 4; ++i) {
        ivec2 at = p + CORNERS[i];
        vec2 into = 0.5 - vec2(CORNERS[i]);
        q[i] = lattice_direction(origin + at);
        middle += 0.25 * q[i];
        k[i] = k_of[k_at(at)];
        half_steps[i] = into * vec2(slope(at, ivec2(1, 0), into.x), slope(at, ivec2(0, 1), into.y));
        sums[i] = counts[i] = 0.0;
        // Corners that are joined, directly or by others, are numbered alike.
        if ((with_next >> i & 1u) != 0u) {
            int from = part[(i + 1) & 3], to = part[i];
            for (int l = 0; l < 4; ++l)
                part[l] = part[l] == from ? to : part[l];
        }
    }
    for (int i = 0; i < 4; ++i) {
        float at_middle = k[i] + half_steps[i].x + half_steps[i].y;
        for (int l = 0; l < 4; ++l)
            if (part[l] == part[i]) {
                sums[l] += at_middle;
                counts[l] += 1.0;
            }
    }
    for (int i = 0; i < 4; ++i) {
        int next = (i + 1) & 3, last = (i + 3) & 3;
        bool joined_next = (with_next >> i & 1u) != 0u, joined_last = (with_next >> last & 1u) != 0u;
        if (part[i] == i)
            put_point(first_further + uint(i), middle, max(sums[i] / counts[i], 0.0));
        // Edges are along x and y in turn.
        float on = (i & 1) == 0 ? half_steps[i].x : half_steps[i].y, back = (i & 1) == 0 ? half_steps[i].y : half_steps[i].x;
        put_point(first_further + uint(4 + i), 0.5 * (q[i] + q[next]),
                  joined_next ? 0.5 * (k[i] + k[next]) : max(k[i] + on, 0.0));
        if (!joined_last)
            put_point(first_further + uint(8 + i), 0.5 * (q[i] + q[last]), max(k[i] + back, 0.0));
        if (isnan(k[i]))
            continue;
        uint corner = corner_number(p + CORNERS[i]), centre = first_further + uint(part[i]);
        add_triangle(p, corner, first_further + uint(4 + i), centre);
        add_triangle(p, corner, centre, first_further + (joined_last ? uint(4 + last) : uint(8 + i)));
    }
}

/// One of the two that a cell of the lattice is split into.
void add_half(ivec2 p, bool upper) {
    uint a = corner_number(p), c = corner_number(p + 1);
    if (upper)
        add_triangle(p, a, corner_number(p + ivec2(1, 0)), c);
    else
        add_triangle(p, a, c, corner_number(p + ivec2(0, 1)));
}

/// Of a cell on whose border there are so many corners.
void add_whole(ivec2 p, int level, int corners, uint first_further) {
    int side = 1 << level;
    if (corners == 4) {
        uint a = corner_number(p), c = corner_number(p + side);
        add_triangle(p, a, corner_number(p + ivec2(side, 0)), c);
        add_triangle(p, a, c, corner_number(p + ivec2(0, side)));
        return;
    }
    ivec2 middle = p + side / 2;
    put_point(first_further, lattice_direction(origin + middle), k_of[k_at(middle)]);
    uint last = corner_number(p);
    for (int place = 1; place <= 4 << level; ++place) {
        ivec2 at = p + on_border(place, level);
        if (!is_corner(at))
            continue;
        uint number = corner_number(at);
        add_triangle(p, first_further, last, number);
        last = number;
    }
}

/// Where it was before, if there is room, else a new place, with more room than the old one.
void take_place(uint point_number, uint index_number) {
    MeshBlock block = blocks[own_block];
    if (point_number > block.point_room) {
        block.point_room = point_number + (block.point_room > 0u ? point_number / 4u : 0u);
        block.first_point = atomicAdd(point_count, block.point_room);
    }
    if (index_number > block.index_room) {
        block.index_room = index_number + (block.index_room > 0u ? index_number / 4u : 0u);
        block.first_index = atomicAdd(index_count, block.index_room);
    }
    bool fits = block.first_point + block.point_room <= uint(points.length()) &&
                block.first_index + block.index_room <= uint(indices.length());
    block.index_count = fits ? index_number : 0u;
    blocks[own_block] = block;
    first_point = block.first_point;
    first_index = block.first_index;
    row_indices[SIDE] = block.index_count;
}

/// Sums of all that come before each.
void sum_up() {
    uint sum = 0u, further = 0u, all_indices = 0u;
    for (int row = 0; row < POINTS; ++row) {
        points_before[row] = sum;
        sum += uint(bitCount(corner_bits[row])) + last_bits[row];
    }
    points_before[POINTS] = sum;
    for (int row = 0; row < SIDE; ++row) {
        uint own = further_points[row], own_indices = row_indices[row];
        further_points[row] = sum + further;
        row_indices[row] = all_indices;
        further += own;
        all_indices += own_indices;
    }
    take_place(sum + further, all_indices);
}

void load_corners(ivec2 cells) {
    int row = int(gl_LocalInvocationIndex);
    if (row < POINTS)
        corner_bits[row] = last_bits[row] = 0u;
    if (row > cells.y)
        return;
    uint bits = corner_bits_of(own_block, row), last = corner_of(own_block, ivec2(SIDE, row));
    // The same points are corners of cells beside it.
    ivec2 place = block_place(own_block);
    int left = block_beside(place, ivec2(-1, 0)), right = block_beside(place, ivec2(1, 0));
    if (left >= 0)
        bits |= corner_of(uint(left), ivec2(cells_in_block(block_place(uint(left))).x, row));
    if (right >= 0) {
        uint corner = corner_of(uint(right), ivec2(0, row));
        bits |= cells.x < SIDE ? corner << cells.x : 0u;
        last |= cells.x < SIDE ? 0u : corner;
    }
    int above = block_beside(place, ivec2(0, -1)), below = block_beside(place, ivec2(0, 1));
    if (row == 0 && above >= 0) {
        bits |= corner_bits_of(uint(above), SIDE);
        last |= corner_of(uint(above), ivec2(SIDE, SIDE));
    }
    if (row == cells.y && below >= 0) {
        bits |= corner_bits_of(uint(below), 0);
        last |= corner_of(uint(below), ivec2(SIDE, 0));
    }
    corner_bits[row] = bits;
    last_bits[row] = last;
}

void count_row(int row, ivec2 cells) {
    uvec2 counts = uvec2(0u);
    if (row < cells.y)
        for (int x = 0; x < cells.x; ++x)
            counts += counts_of(ivec2(x, row), cell_at(ivec2(x, row)));
    further_points[row] = counts.x;
    row_indices[row] = 3u * ways_round(ivec2(0, row)) * counts.y;
}

void add_corners(int row, ivec2 cells) {
    for (int x = 0; x <= cells.x; ++x)
        if (is_corner(ivec2(x, row)))
            put_point(corner_number(ivec2(x, row)), lattice_direction(origin + ivec2(x, row)), k_of[k_at(ivec2(x, row))]);
}

void add_cells(int row, ivec2 cells) {
    uint further = further_points[row];
    next_index = first_index + row_indices[row];
    for (int x = 0; x < cells.x; ++x) {
        ivec2 p = ivec2(x, row);
        uint cell = cell_at(p), kind = cell & 0xfu;
        if (kind == CUT) {
            uint added = counts_of(p, cell).x;
            if (added > 0u)
                add_cut(p, cell >> 4, further);
            further += added;
        } else if (kind > CUT) {
            add_half(p, kind == UPPER);
        } else if (kind != 0u) {
            int level = int(kind - 1u), corner_count = corners_on_border(p, level);
            add_whole(p, level, corner_count, further);
            further += corner_count == 4 ? 0u : 1u;
        }
    }
}

void build_block() {
    origin = block_origin(block_place(own_block));
    ivec2 cells = cells_in_block(block_place(own_block));
    int own = int(gl_LocalInvocationIndex);
    for (int i = own; i < STRIDE * STRIDE; i += 64)
        k_of[i] = lattice_inverse(origin + ivec2(i % STRIDE, i / STRIDE) - MARGIN);
    load_corners(cells);
    barrier();
    if (own < SIDE)
        count_row(own, cells);
    barrier();
    if (own == 0)
        sum_up();
    barrier();
    if (row_indices[SIDE] != 0u) {
        if (own <= cells.y)
            add_corners(own, cells);
        if (own < cells.y)
            add_cells(own, cells);
    }
}

void main() {
    box_radius_m = joins.x;
    tolerance = joins.y;
    if (find_listed(POINTS_OF_CELLS, own_block))
        build_block();
}
