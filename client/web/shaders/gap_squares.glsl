// Which squares of pixels hold gaps; with BESIDE, which hold some or lie beside one that does.
const int TILE_SIDE = 1 << TILE_SHIFT;

layout(location = 0) out uint holds;

#ifdef BESIDE
uniform usampler2D squares;

void main() {
    ivec2 last = textureSize(squares, 0) - 1;
    holds = 0u;
    for (int i = 0; i < 9; ++i)
        holds |= texelFetch(squares, clamp(ivec2(gl_FragCoord.xy) + ivec2(i % 3, i / 3) - 1, ivec2(0), last), 0).x;
}
#else
uniform usampler2DArray eye_origin;

void main() {
    ivec2 last = textureSize(eye_origin, 0).xy - 1;
    holds = 0u;
    for (int i = 0; i < TILE_SIDE * TILE_SIDE; ++i) {
        ivec2 at = TILE_SIDE * ivec2(gl_FragCoord.xy) + ivec2(i % TILE_SIDE, i / TILE_SIDE);
        if (texelFetch(eye_origin, ivec3(min(at, last), 0), 0).x == ORIGIN_GAP)
            holds = 1u;
    }
}
#endif
