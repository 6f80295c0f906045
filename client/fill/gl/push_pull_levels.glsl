// Cells of one level of push_pull.h's pyramid. A layer is r, g, b, w; r is negative where it is open, w where it is
// not there. A texture has them, an eye after the other. Of a level its columns and rows in one eye are known,
// and, third, by how many bits a tile is wide in cells, which is negative where all cells are there.
#include "eye_rays.glsl"
#include "gap_tiles.glsl"

const vec4 NO_LAYER = vec4(-1.0);
const vec3 OPEN = vec3(-1.0);

/// Where a cell's far layer lies in a level's texture, or, for 1, its near one.
ivec3 layer_at(ivec3 cell, int half_of) {
    return ivec3(cell.xy, 2 * cell.z + half_of);
}

bool is_inside(ivec3 level, ivec3 cell) {
    return all(greaterThanEqual(cell.xy, ivec2(0))) && all(lessThan(cell.xy, level.xy));
}

/// Cells outside, and those of tiles that are not, have none: nobody has written those.
bool is_there(ivec3 level, ivec3 cell) {
    return is_inside(level, cell) &&
           (level.z < 0 || tile_state(ivec3(cell.xy >> level.z, cell.z)) != NOT_THERE);
}
