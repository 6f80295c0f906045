// The colour of a pixel of a decoder's planes, by the very integers of equistream/yuv.h: the colours are those of the
// CPU, bit for bit.
#include "decoder_planes.glsl"

float byte_of(int sum) {
    return float(clamp(sum >> SUM_BITS, 0, 255)) / 255.0;
}

vec3 rgb_of(ivec2 at) {
    ivec2 chroma = chroma_eighths(at) - 8 * 128;
    int base = LUMA_GAIN * int(luma_at(at)) + OFFSET;
    return vec3(byte_of(base + RED_FROM_CR * chroma.y),
                byte_of(base + GREEN_FROM_CB * chroma.x + GREEN_FROM_CR * chroma.y),
                byte_of(base + BLUE_FROM_CB * chroma.x));
}
