// What gap pixels see is not known, where an eye's depth was found by the engine.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 0, r32f) uniform writeonly image2DArray eye_inverse_planar;

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    ivec2 size = imageSize(eye_inverse_planar).xy;
    if (all(lessThan(at.xy, size)) && texelFetch(eye_origin, at, 0).x == ORIGIN_GAP)
        imageStore(eye_inverse_planar, at, vec4(UNKNOWN));
}
