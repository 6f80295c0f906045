// The nearest of what was drawn into each pixel (splat.glsl) as inverse planar depth; nothing is drawn then.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0, r32ui) uniform uimage2DArray nearest;
layout(binding = 1, r32f) uniform writeonly image2DArray eye_inverse_planar;

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at.xy, imageSize(nearest).xy)))
        return;
    uint key = imageLoad(nearest, at).x;
    imageStore(eye_inverse_planar, at, vec4(key == 0u ? UNKNOWN : uintBitsToFloat(key - 1u)));
    imageStore(nearest, at, uvec4(0u));
}
