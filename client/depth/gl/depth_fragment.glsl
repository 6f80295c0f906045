// Depth, and which triangle it is of: 1 + 256 times its cluster's item and its place in the cluster; 0 is none.
#ifdef MASKED
#include "masks.glsl"

in vec2 mask_uv;
flat in uint mask;
#endif

flat in uint item;
layout(location = 0) out uint triangle;

void main() {
#ifdef MASKED
    if (!covers(mask, mask_uv))
        discard;
#endif
    triangle = 1u + item * MAX_TRIANGLES + uint(gl_PrimitiveID);
}
