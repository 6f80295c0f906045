// The blocks that a source's lattice (source_lattice.glsl) is made of, and what source_blocks.glsl knows of each.
#ifndef SOURCE_BLOCKS_BINDING
#define SOURCE_BLOCKS_BINDING 0
#endif

struct SourceBlock {
    vec4 cone;      // of all directions: its axis, and the cosine of its half angle
    vec2 inverses;  // the largest and the smallest k in it and beside it; where nothing is known, the smaller first
    float sine;     // of that angle
    uint sum;       // of its samples, and of those that its cells hang on: others have another, never 0
};

layout(std430, binding = SOURCE_BLOCKS_BINDING) buffer SourceBlocks {
    SourceBlock source_blocks[];
};

uniform ivec2 block_grid;  // columns and rows of blocks

const float LARGEST = 3.4e38;
const int SIDE = 1 << BLOCK_LEVELS, POINTS = SIDE + 1;  // of a block, in cells and in points

ivec2 block_place(uint block) {
    return ivec2(block % uint(block_grid.x), block / uint(block_grid.x));
}

ivec2 block_origin(ivec2 place) {
    return ivec2(source_closes != 0 ? 0 : -1, -1) + place * SIDE;
}

ivec2 cells_in_block(ivec2 place) {
    return min(ivec2(SIDE), source_size - block_origin(place));
}

/// The block beside one; -1: there is none.
int block_beside(ivec2 place, ivec2 step) {
    ivec2 at = place + step;
    if (source_closes != 0)
        at.x = at.x < 0 ? block_grid.x - 1 : at.x >= block_grid.x ? 0 : at.x;
    return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, block_grid)) ? at.y * block_grid.x + at.x : -1;
}

const ivec2 BESIDE[4] = ivec2[4](ivec2(-1, 0), ivec2(1, 0), ivec2(0, -1), ivec2(0, 1));

bool shows_something(SourceBlock block) {
    return block.inverses.y <= block.inverses.x;
}

/// Whether anything of a cone of directions between two inverse distances lies before a plane through the eye: `plane`
/// is its normal, and how far the eye lies along that from the source.
bool is_before(vec4 plane, SourceBlock block, vec2 inverses) {
    // The largest n . q over the cone, less the smallest k n . eye.
    float cosine = dot(plane.xyz, block.cone.xyz), sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    float largest = cosine >= block.cone.w ? 1.0 : cosine * block.cone.w + sine * block.sine;
    return largest - min(inverses.x * plane.w, inverses.y * plane.w) >= -1e-5;
}

/// Each bit of the result hangs on all of x.
uint mixed(uint x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}
