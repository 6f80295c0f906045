// The samples around a position that a grid holds, and their weights. Needs source_grid.glsl.

struct Taps {
    ivec2 samples[4], places[4];  // on the grid, and in its picture
};

#ifdef PATCHES
layout(binding = 4) uniform isampler2DArray patch_slots;  // of each sphere's blocks; -1: none

uniform ivec2 patch_spheres;  // which sphere's patches each eye takes
uniform int block_side;
uniform int slot_columns;     // of the atlas
int sphere_of_patches;        // set by main()

bool find_sample(ivec2 s, out ivec2 place) {
    int slot = texelFetch(patch_slots, ivec3(s / block_side, sphere_of_patches), 0).x;
    place = ivec2(slot % slot_columns, slot / slot_columns) * block_side + s % block_side;
    return slot >= 0;
}
#else
bool find_sample(ivec2 s, out ivec2 place) {
    place = s;
    return true;
}
#endif

/// The four samples around a position and their bilinear weights, 0 of those that the grid does not hold; false where
/// it holds none.
bool find_taps(vec2 position, out Taps taps, out vec4 weights) {
    vec2 from_first = position - 0.5;
    ivec2 corner = ivec2(floor(from_first));
    vec2 s = from_first - vec2(corner);
    weights = vec4((1.0 - s.x) * (1.0 - s.y), s.x * (1.0 - s.y), (1.0 - s.x) * s.y, s.x * s.y);
    bool any_held = false;
    for (int k = 0; k < 4; ++k) {
        taps.samples[k] = wrapped(corner + ivec2(k & 1, k >> 1));
        bool held = find_sample(taps.samples[k], taps.places[k]);
        any_held = any_held || held;
        weights[k] = held ? weights[k] : 0.0;
    }
    return any_held;
}
