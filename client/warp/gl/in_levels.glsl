// Colours of 8 bits are rounded here, as on the CPU, and not by drivers: an NVIDIA driver (580.159) stored up to 4 % of
// an eye's pixels a level lower.
vec3 in_levels(vec3 colour) {
    return floor(255.0 * colour + 0.5) / 255.0;
}
