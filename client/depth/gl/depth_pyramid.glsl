// A level of the pyramid from the one before it, or from depth itself: the farthest of a block, 0 for a miss.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

#include "depth_views.glsl"

layout(binding = 0) uniform sampler2DArray finer;
layout(binding = 0, r32f) uniform writeonly image2DArray coarser;

uniform int finer_level;  // -1: depth
const float nearest_of_all = 1.0;

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at.xy, imageSize(coarser).xy)))
        return;
    float farthest = nearest_of_all;
    if (finer_level < 0) {
        // Blocks beside the view hold nothing that could be seen.
        ivec2 first = at.xy * PYRAMID_BLOCK, end = min(first + PYRAMID_BLOCK, ivec2(views[at.z].size.xy));
        for (int y = first.y; y < end.y; ++y)
            for (int x = first.x; x < end.x; ++x)
                farthest = min(farthest, texelFetch(finer, ivec3(x, y, at.z), 0).x);
    } else {
        ivec2 last = textureSize(finer, finer_level).xy - 1;
        for (int k = 0; k < 4; ++k)
            farthest = min(farthest,
                           texelFetch(finer, ivec3(min(2 * at.xy + ivec2(k & 1, k >> 1), last), at.z), finer_level).x);
    }
    imageStore(coarser, at, vec4(farthest));
}
