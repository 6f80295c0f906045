// A decoder's 4:2:0 planes, and the chroma between its samples as equistream/yuv.h has it.
layout(binding = 0) uniform usampler2D luma;
layout(binding = 1) uniform usampler2D cb;
layout(binding = 2) uniform usampler2D cr;

ivec2 chroma_sum(ivec2 left, ivec2 right) {
    return ivec2(texelFetch(cb, left, 0).x + texelFetch(cb, right, 0).x,
                 texelFetch(cr, left, 0).x + texelFetch(cr, right, 0).x);
}

// Cb and Cr of a pixel, in eighths.
ivec2 chroma_eighths(ivec2 at) {
    ivec2 size = textureSize(cb, 0);
    int left = at.x / 2, right = min((at.x + 1) / 2, size.x - 1), near = at.y / 2;
    int far = clamp((at.y & 1) == 0 ? near - 1 : near + 1, 0, size.y - 1);
    return 3 * chroma_sum(ivec2(left, near), ivec2(right, near)) + chroma_sum(ivec2(left, far), ivec2(right, far));
}
