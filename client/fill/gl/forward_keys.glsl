// What is drawn forward into gap pixels: the largest key stays, so that of surfaces the nearest does; where there is
// none, of mere footprints, whose keys are negative, the farthest, because what is in front would else grow into the
// background that it uncovered. Whole numbers in the order of the keys.
layout(binding = 0, r32i) uniform iimage2DArray forward_keys;

const int NO_KEY = -2147483647 - 1;

void give_key(ivec3 at, float key) {
    int bits = floatBitsToInt(key);
    imageAtomicMax(forward_keys, at, bits < 0 ? bits ^ 0x7fffffff : bits);
}

/// NaN where nothing was drawn.
float inverse_of_key(int key) {
    return key == NO_KEY ? UNKNOWN : abs(intBitsToFloat(key < 0 ? key ^ 0x7fffffff : key));
}
