// A decoder's 10-bit planes to PQ R'G'B' by the formula of equistream/yuv.h, then to the display by OpenColorIO's shader,
// which stands before this text: pq_to_display.
#include "decoder_planes.glsl"

layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0, rgba8) uniform writeonly image2D colour;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at, imageSize(colour))))
        return;
    vec2 chroma = (vec2(chroma_eighths(at)) / 8.0 - CHROMA_MIDDLE) / CHROMA_SCALE;
    float grey = (float(luma_at(at)) - LUMA_BLACK) / LUMA_SCALE;
    vec3 pq = grey + vec3(RED_FROM_CR * chroma.y, GREEN_FROM_CB * chroma.x + GREEN_FROM_CR * chroma.y,
                          BLUE_FROM_CB * chroma.x);
    vec3 shown = pq_to_display(vec4(clamp(pq, 0.0, 1.0), 1.0)).rgb;
    // NaN, of a view that has no value there, is black as on the CPU.
    imageStore(colour, at, vec4(mix(clamp(shown, 0.0, 1.0), vec3(0.0), isnan(shown)), 1.0));
}
