// Pixels that wait for the whole rule.

layout(std430, binding = 0) buffer PixelList {
    uint pixel_groups[3];  // of 256 invocations
    uint pixel_count;
    uint pixels[];  // column, row and eye in 15, 15 and 2 bits
};

void append(ivec3 at) {
    uint before = atomicAdd(pixel_count, 1u);
    pixels[before] = uint(at.x) | uint(at.y) << 15 | uint(at.z) << 30;
    if ((before & 255u) == 0u)
        atomicAdd(pixel_groups[0], 1u);
}

ivec3 listed_pixel(uint index) {
    uint pixel = pixels[index];
    return ivec3(pixel & 0x7fffu, pixel >> 15 & 0x7fffu, pixel >> 30);
}
