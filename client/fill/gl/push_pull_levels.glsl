// Cells of one level of push_pull.h's pyramid. A layer is r, g, b, w; r is negative where it is open, w where it is
// not there. The far layer of a cell comes before its near one. Of a level its columns and rows in one eye are known,
// and, third, by how many bits a tile is wide in cells, which is negative where all cells are there.
#include "eye_rays.glsl"
#include "gap_tiles.glsl"

const vec4 NO_LAYER = vec4(-1.0);
const vec3 OPEN = vec3(-1.0);

int cell_number(ivec3 level, ivec3 cell) {
    return 2 * ((cell.z * level.y + cell.y) * level.x + cell.x);
}

/// Cells outside, and those of tiles that are not, have none: nobody has written those.
bool is_there(ivec3 level, ivec3 cell) {
    bool inside = all(greaterThanEqual(cell.xy, ivec2(0))) && all(lessThan(cell.xy, level.xy));
    return inside && (level.z < 0 || tile_state(ivec3(cell.xy >> level.z, cell.z)) != NOT_THERE);
}
