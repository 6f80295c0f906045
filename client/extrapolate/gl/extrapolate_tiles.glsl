// Tiles of a picture, each a work group's, that are not afterwards as the picture shows them: something moves in them or
// came to them. Those that something had come to the time before are as the picture shows them again.
layout(std430, binding = 2) buffer ExtrapolateTiles {
    uint groups[3];  // of a pass over the list
    uint listed;
    uint tiles[];    // states of all, then the list
};

const uint MOVES = 1u, REACHED = 2u, WAS_REACHED = 4u;
const uint MAX_GROUPS_IN_ROW = 1024u;  // drivers need not take more than 65,535

ivec2 tile_grid() {
    return (source_size + ivec2(GROUP_WIDTH, GROUP_HEIGHT) - 1) / ivec2(GROUP_WIDTH, GROUP_HEIGHT);
}

uint tile_count() {
    return uint(tile_grid().x * tile_grid().y);
}

void mark_tile(ivec2 pixel, uint state) {
    int tile = pixel.y / GROUP_HEIGHT * tile_grid().x + pixel.x / GROUP_WIDTH;
    if ((tiles[tile] & state) == 0u)
        atomicOr(tiles[tile], state);
}
