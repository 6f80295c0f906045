// Pixels that wait for the whole rule, where a first pass has a simple one (client/warp/gl/resample.h).

const uint LIST_GROUP = 256u;
const uint MAX_GROUPS = 65535u;  // along an axis that every driver has; more go along the next one

layout(std430, binding = 9) buffer PixelListHead {
    uint pixel_groups[3];  // of LIST_GROUP invocations
    uint pixel_count;
};
layout(std430, binding = 8) buffer PixelList {
    uint pixels[];  // column, row and layer in 15, 15 and 2 bits
};

void append(ivec3 at) {
    pixels[atomicAdd(pixel_count, 1u)] = uint(at.x) | uint(at.y) << 15 | uint(at.z) << 30;
}

/// Of the invocation, from the work group that it is in.
uint list_index(uvec3 group, uint invocation) {
    return (group.y * MAX_GROUPS + group.x) * LIST_GROUP + invocation;
}

ivec3 listed_pixel(uint index) {
    uint pixel = pixels[index];
    return ivec3(pixel & 0x7fffu, pixel >> 15 & 0x7fffu, pixel >> 30);
}
