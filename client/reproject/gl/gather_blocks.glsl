// What blocks of the source hold, for engine `gather`: how near and how far, and the cone of directions around them. A
// work group has a block and the samples beside it, an invocation a column of them.
layout(local_size_x = GATHER_BLOCK_GROUP) in;

#include "source_grid.glsl"
#include "source_lattice.glsl"
#include "gather_block.glsl"

shared float nearest[GATHER_BLOCK_GROUP], farthest[GATHER_BLOCK_GROUP], least_cosine[GATHER_BLOCK_GROUP];

void main() {
    ivec2 first = ivec2(gl_WorkGroupID.xy) * GATHER_BLOCK_SIDE - 1;
    ivec2 last = min(first + GATHER_BLOCK_SIDE + 1, source_size);
    vec3 axis = lattice_direction((first + last) / 2);
    int column = int(gl_LocalInvocationID.x);
    // A block without depth shows nothing.
    float near = 0.0, far = LARGEST, cosine = 1.0;
    for (int x = first.x + column; x <= last.x; x += GATHER_BLOCK_GROUP)
        for (int y = first.y; y <= last.y; ++y) {
            float k = lattice_inverse(ivec2(x, y));
            if (k >= 0.0) {
                near = max(near, k);
                far = min(far, k);
            }
            cosine = min(cosine, dot(axis, lattice_direction(ivec2(x, y))));
        }
    nearest[column] = near;
    farthest[column] = far;
    least_cosine[column] = cosine;
    barrier();
    if (column != 0)
        return;
    for (int i = 1; i < GATHER_BLOCK_GROUP; ++i) {
        near = max(near, nearest[i]);
        far = min(far, farthest[i]);
        cosine = min(cosine, least_cosine[i]);
    }
    cosine = max(cosine - 1e-6, -1.0);
    blocks[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] =
        GatherBlock(vec4(axis, cosine), vec4(near, far, sqrt(max(1.0 - cosine * cosine, 0.0)), 0.0));
}
