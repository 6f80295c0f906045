// A pixel's matte surface in four words: instance and one, or 0 for none, and whether the pixel is a gap; halves of its
// base colour and its normal.
const uint GAP_BIT = 0x80000000u;

uvec4 packed_surface(uint instance, bool is_gap, vec3 base_colour, vec3 normal) {
    return uvec4((instance + 1u) | (is_gap ? GAP_BIT : 0u), packHalf2x16(base_colour.rg),
                 packHalf2x16(vec2(base_colour.b, normal.x)), packHalf2x16(normal.yz));
}
vec3 base_of(uvec4 surface) {
    return vec3(unpackHalf2x16(surface.y), unpackHalf2x16(surface.z).x);
}
vec3 normal_of(uvec4 surface) {
    return vec3(unpackHalf2x16(surface.z).y, unpackHalf2x16(surface.w));
}
