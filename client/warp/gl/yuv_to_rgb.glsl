// A decoder's planes to RGB.
#include "yuv_colour.glsl"

layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0, rgba8) uniform writeonly image2D colour;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID);
    if (all(lessThan(at, imageSize(colour))))
        imageStore(colour, at, vec4(rgb_of(at), 1.0));
}
