// Finds the components of wide_gaps.glsl, and which are wide, in three passes: START makes every gap pixel a root, JOIN
// joins neighbours (Playne and Hawick 2018, "A new algorithm for parallel connected-component labelling on GPUs"),
// the last one marks the roots of squares.
layout(local_size_x = 256) in;

layout(binding = 3) uniform usampler2DArray eye_origin;

#include "gap_tiles.glsl"
#include "wide_gaps.glsl"

#ifdef MARK
uniform int side;  // of the square that wide components hold
#endif

bool is_gap(ivec3 at, ivec2 size) {
    return all(greaterThanEqual(at.xy, ivec2(0))) && all(lessThan(at.xy, size)) &&
           texelFetch(eye_origin, at, 0).x == ORIGIN_GAP;
}

#ifdef JOIN
void join(uint a, uint b) {
    while (true) {
        a = root_of(a);
        b = root_of(b);
        if (a == b)
            return;
        uint later = max(a, b), earlier = min(a, b), before = atomicMin(parents[later], earlier);
        // Somebody else may have given it another parent meanwhile: that one is joined too.
        if (before == later)
            return;
        a = before;
        b = earlier;
    }
}
#endif

void main() {
    ivec3 at;
    ivec2 size = textureSize(eye_origin, 0).xy;
    if (!listed_cell(1, TILE_SHIFT, at) || !is_gap(at, size))
        return;
    uint pixel = pixel_number(at, size);
#ifdef START
    parents[pixel] = pixel;
#endif
#ifdef JOIN
    const ivec2 earlier[4] = ivec2[4](ivec2(-1, 0), ivec2(-1, -1), ivec2(0, -1), ivec2(1, -1));
    for (int k = 0; k < 4; ++k)
        if (is_gap(at + ivec3(earlier[k], 0), size))
            join(pixel, pixel_number(at + ivec3(earlier[k], 0), size));
#endif
#ifdef MARK
    bool square = is_gap(at - ivec3(side - 1, side - 1, 0), size);
    for (int y = 0; square && y < side; ++y)
        for (int x = 0; square && x < side; ++x)
            square = is_gap(at - ivec3(x, y, 0), size);
    if (square) {
        uint root = root_of(pixel);
        atomicOr(wide_roots[root / 32u], 1u << (root % 32u));
    }
#endif
}
