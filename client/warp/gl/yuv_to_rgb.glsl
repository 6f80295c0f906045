// A decoder's planes to RGB, by the very integers of equistream/yuv.h: the colours are those of the CPU, bit for bit.
#include "decoder_planes.glsl"

layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0, rgba8) uniform writeonly image2D colour;

float byte_of(int sum) {
    return float(clamp(sum >> SUM_BITS, 0, 255)) / 255.0;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at, imageSize(colour))))
        return;
    ivec2 chroma = chroma_eighths(at) - 8 * 128;
    int base = LUMA_GAIN * int(luma_at(at)) + OFFSET;
    imageStore(colour, at,
               vec4(byte_of(base + RED_FROM_CR * chroma.y),
                    byte_of(base + GREEN_FROM_CB * chroma.x + GREEN_FROM_CR * chroma.y),
                    byte_of(base + BLUE_FROM_CB * chroma.x), 1.0));
}
