// What gather_blocks.glsl knows of each block of a source.
struct GatherBlock {
    vec4 cone;     // its axis, and the cosine of its half angle
    vec4 inverse;  // the largest and the smallest k in it, and the sine of that angle
};

layout(std430, binding = 0) buffer Blocks {
    GatherBlock blocks[];
};

const float LARGEST = 3.4e38;
