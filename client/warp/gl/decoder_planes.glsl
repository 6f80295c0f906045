// A decoder's 4:2:0 planes, and the chroma between its samples (see equistream/yuv.h).
#ifdef IN_ONE_BUFFER
layout(binding = 0) uniform usamplerBuffer samples;
// Of each plane its first sample, and how many lie from row to row.
uniform ivec2 luma_place;
uniform ivec2 cb_place;
uniform ivec2 cr_place;
uniform ivec2 chroma_size;

uint sample_at(ivec2 place, ivec2 at) {
    return texelFetch(samples, place.x + at.y * place.y + at.x).x;
}
uint luma_at(ivec2 at) {
    return sample_at(luma_place, at);
}
ivec2 chroma_at(ivec2 at) {
    return ivec2(sample_at(cb_place, at), sample_at(cr_place, at));
}
#else
layout(binding = 0) uniform usampler2D luma;
layout(binding = 1) uniform usampler2D cb;
layout(binding = 2) uniform usampler2D cr;

uint luma_at(ivec2 at) {
    return texelFetch(luma, at, 0).x;
}
ivec2 chroma_at(ivec2 at) {
    return ivec2(texelFetch(cb, at, 0).x, texelFetch(cr, at, 0).x);
}
#endif

ivec2 chroma_sum(ivec2 left, ivec2 right) {
    return chroma_at(left) + chroma_at(right);
}

// Cb and Cr of a pixel, in eighths.
ivec2 chroma_eighths(ivec2 at) {
#ifdef IN_ONE_BUFFER
    ivec2 size = chroma_size;
#else
    ivec2 size = textureSize(cb, 0);
#endif
    int left = at.x / 2, right = min((at.x + 1) / 2, size.x - 1), near = at.y / 2;
    int far = clamp((at.y & 1) == 0 ? near - 1 : near + 1, 0, size.y - 1);
    return 3 * chroma_sum(ivec2(left, near), ivec2(right, near)) + chroma_sum(ivec2(left, far), ivec2(right, far));
}
