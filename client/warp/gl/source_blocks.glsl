// What blocks of a source's lattice hold: how near and how far, the cone of directions around them, and a sum that
// tells other samples from the same ones. A work group has a block, an invocation a column of points, two more on each
// side.
layout(local_size_x = 64) in;

#include "source_grid.glsl"
#include "source_lattice.glsl"
#include "source_block.glsl"

const int MARGIN = 2;

shared float nearest[64], farthest[64];
shared uint sums[64];
shared float cosines[9];

void main() {
    ivec2 place = ivec2(gl_WorkGroupID.xy), origin = block_origin(place), cells = cells_in_block(place);
    vec3 axis = lattice_direction(origin + cells / 2);
    int own = int(gl_LocalInvocationIndex), columns = cells.x + 1 + 2 * MARGIN, rows = own < columns ? cells.y + 1 + 2 * MARGIN : 0;
    bool is_beside = own > 0 && own < columns - 1;
    float near = 0.0, far = LARGEST;
    uint sum = uint(own);
    for (int row = 0; row < rows; ++row) {
        float k = lattice_inverse(origin - MARGIN + ivec2(own, row));
        sum = mixed(sum ^ floatBitsToUint(k));
        if (k >= 0.0 && is_beside && row > 0 && row < rows - 1) {
            near = max(near, k);
            far = min(far, k);
        }
    }
    nearest[own] = near;
    farthest[own] = far;
    sums[own] = sum;
    if (own < 9)
        cosines[own] = dot(axis, lattice_direction(origin + ivec2(own % 3, own / 3) * cells / 2));
    barrier();
    if (own != 0)
        return;
    for (int i = 1; i < columns; ++i) {
        near = max(near, nearest[i]);
        far = min(far, farthest[i]);
        sum = mixed(sum ^ sums[i]);
    }
    // The farthest of the corners and of the sides' middles, and half a step more for sides that bulge, as
    // SourceLattice has it.
    float least = 1.0;
    for (int i = 0; i < 9; ++i)
        least = min(least, cosines[i]);
    float radius = min(1.1 * acos(clamp(least, -1.0, 1.0)) + 1e-3, PI);
    source_blocks[place.y * block_grid.x + place.x] =
        SourceBlock(vec4(axis, cos(radius)), vec2(near, far), sin(radius), max(sum, 1u));
}
