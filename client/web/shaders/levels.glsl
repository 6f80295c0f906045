// Cells of one level of push_pull.h's pyramid, of one eye: layers far and near.
const vec4 NO_LAYER = vec4(-1.0);
const vec3 OPEN = vec3(-1.0);

ivec3 layer_at(ivec3 cell, int half_of) {
    return ivec3(cell.xy, half_of);
}
