// Colours of 8 bits are rounded here: NVIDIA's driver (580.159) stores one in thirty a level lower than the nearest.
vec3 in_levels(vec3 colour) {
    return floor(255.0 * colour + 0.5) / 255.0;
}
