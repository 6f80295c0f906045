// A decoder's planes to RGB, by the very integers of equistream/yuv.h: the colours are those of the CPU, bit for bit.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform usampler2D luma;
layout(binding = 1) uniform usampler2D cb;
layout(binding = 2) uniform usampler2D cr;
layout(binding = 0, rgba8) uniform writeonly image2D colour;

ivec2 eighths(ivec2 left, ivec2 right) {
    return ivec2(texelFetch(cb, left, 0).x + texelFetch(cb, right, 0).x,
                 texelFetch(cr, left, 0).x + texelFetch(cr, right, 0).x);
}

float byte_of(int sum) {
    return float(clamp(sum >> SUM_BITS, 0, 255)) / 255.0;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at, imageSize(colour))))
        return;
    ivec2 size = textureSize(cb, 0);
    int left = at.x / 2, right = min((at.x + 1) / 2, size.x - 1), near = at.y / 2;
    int far = clamp((at.y & 1) == 0 ? near - 1 : near + 1, 0, size.y - 1);
    ivec2 chroma = 3 * eighths(ivec2(left, near), ivec2(right, near)) + eighths(ivec2(left, far), ivec2(right, far)) -
                   8 * 128;
    int base = LUMA_GAIN * int(texelFetch(luma, at, 0).x) + OFFSET;
    imageStore(colour, at,
               vec4(byte_of(base + RED_FROM_CR * chroma.y),
                    byte_of(base + GREEN_FROM_CB * chroma.x + GREEN_FROM_CR * chroma.y),
                    byte_of(base + BLUE_FROM_CB * chroma.x), 1.0));
}
