// What of each pixel's square surroundings its row has: sums and maxima that map.glsl goes on with along columns.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 3) uniform usampler2DArray surroundings;
// The sum of contrast; and the largest bend, plus 256 where a silhouette is within two pixels, 512 within one, 1024
// here.
layout(binding = 0, rg16ui) uniform writeonly uimage2DArray rows;

#include "map_numbers.glsl"

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    ivec2 size = imageSize(rows).xy;
    if (any(greaterThanEqual(at.xy, size)))
        return;
    int step = numbers[at.z].reach.x, reach = numbers[at.z].reach.y;
    uint sum = 0u, bend = 0u, marks = 0u;
    for (int x = max(at.x - reach, 0); x <= min(at.x + reach, size.x - 1); ++x) {
        uvec3 there = texelFetch(surroundings, ivec3(x, at.yz), 0).xyz;
        int away = abs(x - at.x);
        sum += there.x;
        bend = max(bend, away == 0 || away == step ? there.y : 0u);
        uint within = away == 0 ? 1792u : away == 1 ? 768u : away == 2 ? 256u : 0u;
        marks |= there.z != 0u ? within : 0u;
    }
    imageStore(rows, at, uvec4(sum, bend | marks, 0u, 0u));
}
