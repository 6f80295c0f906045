// Which blocks of a mesh (mesh_lists.glsl) each eye may see something of, SeenThrough of source_lattice.h, and which of
// them have to be built first.
layout(local_size_x = 64) in;

#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "mesh_lists.glsl"

uniform int eye_count;
uniform vec2 eye_size;

vec3 corner_ray(EyeRays eye, vec2 corner) {
    vec2 at = corner * eye_size - 0.5;
    return eye.corner.xyz + at.x * eye.right.xyz + at.y * eye.down.xyz;
}

bool may_show(EyeRays eye, SourceBlock block) {
    const vec2 corners_of_view[5] = vec2[5](vec2(0.0), vec2(1.0, 0.0), vec2(1.0), vec2(0.0, 1.0), vec2(0.0));
    // Along cuts a surface goes on by half a slope each way, and no slope is more than all that there is.
    float span = block.inverses.x - block.inverses.y;
    vec2 inverses = vec2(block.inverses.x + span, max(block.inverses.y - span, 0.0));
    bool shown = shows_something(block);
    for (int i = 0; i < 4; ++i) {
        vec3 inwards = normalize(cross(corner_ray(eye, corners_of_view[i]), corner_ray(eye, corners_of_view[i + 1])));
        shown = shown && is_before(vec4(inwards, dot(inwards, eye.eye.xyz)), block, inverses);
    }
    return shown;
}

void append(uint list, uint block) {
    uint i = atomicAdd(listed[list], 1u);
    lists[list * block_count() + i] = block;
    atomicMax(groups[3u * list], min(i + 1u, MAX_GROUPS_IN_ROW));
    atomicMax(groups[3u * list + 1u], i / MAX_GROUPS_IN_ROW + 1u);
}

void want_cells(uint block) {
    uint of = source_blocks[block].sum;
    if (atomicExchange(blocks[block].cells_of, of) != of)
        append(CELLS, block);
}

void main() {
    uint own = gl_GlobalInvocationID.x;
    if (own >= block_count())
        return;
    SourceBlock block = source_blocks[own];
    uint seen = 0u;
    for (int eye = 0; eye < eye_count; ++eye)
        seen |= may_show(eyes[eye], block) ? 1u << eye : 0u;
    blocks[own].seen = seen;
    if (seen == 0u)
        return;
    // Its cells meet those beside it in their corners, too.
    ivec2 place = block_place(own);
    int beside[4];
    uint of = block.sum;
    for (int i = 0; i < 4; ++i) {
        beside[i] = block_beside(place, BESIDE[i]);
        of = mixed(of ^ (beside[i] >= 0 ? source_blocks[beside[i]].sum : 0u));
    }
    of = max(of, 1u);
    if (blocks[own].points_of == of)
        return;
    blocks[own].points_of = of;
    append(POINTS_OF_CELLS, own);
    want_cells(own);
    for (int i = 0; i < 4; ++i)
        if (beside[i] >= 0)
            want_cells(uint(beside[i]));
}
