// What surface_colour.glsl says. One pixel of resample_first.glsl's list is one invocation.
layout(local_size_x = 256) in;  // LIST_GROUP

layout(binding = 0, rgba8) uniform writeonly image2DArray eye_colour;
layout(binding = 1, r8ui) uniform writeonly uimage2DArray eye_origin;

#include "surface_colour.glsl"
#include "pixel_list.glsl"

void main() {
    uint index = list_index(gl_WorkGroupID, gl_LocalInvocationIndex);
    if (index >= pixel_count)
        return;
    ivec3 at = listed_pixel(index);
    vec4 colour = seen_colour(at);
    imageStore(eye_colour, at, colour);
    imageStore(eye_origin, at, uvec4(colour.a > 0.0 ? ORIGIN_SOURCE : ORIGIN_GAP));
}
