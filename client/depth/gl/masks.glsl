// Alpha masks: the nearest texel, as AlphaMask::covers has it.

struct Mask {
    uint first_bit, width, height, wrap;  // wrap: u + 4 v; 0 repeat, 1 clamp, 2 mirror
};
layout(std430, binding = 5) readonly buffer InstanceMasks {
    uint mask_of_instance[];
};
layout(std430, binding = 6) readonly buffer Masks {
    Mask masks[];
};
layout(std430, binding = 7) readonly buffer MaskBits {
    uint bits[];
};

uint texel(float x, uint size, uint wrap) {
    if (wrap == 0u) {
        x -= floor(x);
    } else if (wrap == 2u) {
        x -= 2.0 * floor(0.5 * x);
        x = x > 1.0 ? 2.0 - x : x;
    }
    x = x > 0.0 ? min(x, 1.0) : 0.0;
    return min(uint(x * float(size)), size - 1u);
}

bool covers(uint mask, vec2 uv) {
    Mask m = masks[mask];
    uint bit = m.first_bit + texel(uv.y, m.height, m.wrap / 4u) * m.width + texel(uv.x, m.width, m.wrap % 4u);
    return (bits[bit / 32u] >> (bit % 32u) & 1u) != 0u;
}
