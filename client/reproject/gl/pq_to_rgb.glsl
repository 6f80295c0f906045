// A decoder's 10-bit planes to PQ R'G'B' by the formula of equistream/pq.h, then to the display by OpenColorIO's shader,
// which stands before this text: pq_to_display.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform usampler2D luma;
layout(binding = 1) uniform usampler2D cb;
layout(binding = 2) uniform usampler2D cr;
layout(binding = 0, rgba8) uniform writeonly image2D colour;

ivec2 sum(ivec2 left, ivec2 right) {
    return ivec2(texelFetch(cb, left, 0).x + texelFetch(cb, right, 0).x,
                 texelFetch(cr, left, 0).x + texelFetch(cr, right, 0).x);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at, imageSize(colour))))
        return;
    ivec2 size = textureSize(cb, 0);
    int left = at.x / 2, right = min((at.x + 1) / 2, size.x - 1), near = at.y / 2;
    int far = clamp((at.y & 1) == 0 ? near - 1 : near + 1, 0, size.y - 1);
    vec2 chroma = vec2(3 * sum(ivec2(left, near), ivec2(right, near)) + sum(ivec2(left, far), ivec2(right, far))) / 8.0;
    chroma = (chroma - CHROMA_MIDDLE) / CHROMA_SCALE;
    float grey = (float(texelFetch(luma, at, 0).x) - LUMA_BLACK) / LUMA_SCALE;
    vec3 pq = grey + vec3(RED_FROM_CR * chroma.y, GREEN_FROM_CB * chroma.x + GREEN_FROM_CR * chroma.y,
                          BLUE_FROM_CB * chroma.x);
    vec3 shown = pq_to_display(vec4(clamp(pq, 0.0, 1.0), 1.0)).rgb;
    // NaN, of a view that has no value there, is black as on the CPU.
    imageStore(colour, at, vec4(mix(clamp(shown, 0.0, 1.0), vec3(0.0), isnan(shown)), 1.0));
}
