// Connected components of gap pixels, corners counted, as a forest: each pixel's parent comes before it in the picture,
// roots are their own. Of roots a bit says whether their component holds a square. Only gap pixels count.
layout(std430, binding = 2) coherent buffer Parents {
    uint parents[];
};
layout(std430, binding = 3) buffer WideRoots {
    uint wide_roots[];
};

uint pixel_number(ivec3 at, ivec2 size) {
    return uint((at.z * size.y + at.y) * size.x + at.x);
}

uint root_of(uint pixel) {
    uint parent = parents[pixel];
    while (parent != pixel) {
        pixel = parent;
        parent = parents[pixel];
    }
    return pixel;
}

bool is_wide(uint pixel) {
    uint root = root_of(pixel);
    return (wide_roots[root / 32u] >> (root % 32u) & 1u) != 0u;
}
