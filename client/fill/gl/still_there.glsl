// Depth of an earlier picture's samples, NaN where its surface is not there any more: the main picture, of any
// camera, looks through it. The same as SeenThrough in picture_passes.cpp.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 1) uniform sampler2D source_depth;
layout(binding = 4) uniform sampler2D main_depth;
layout(binding = 0, r32f) uniform writeonly image2D depth_still_there;

#define OTHER_GRID  // main's
#include "source_grid.glsl"
#include "depth_clearance.glsl"

uniform mat4 main_from_source;
uniform vec2 joins;  // box radius in metres, sin e

bool is_still_there(vec3 point_m) {
    vec2 position = position_in_other(point_m);
    if (!(all(greaterThanEqual(position, vec2(0.0))) && all(lessThan(position, vec2(other.source_size)))))
        return true;
    float clearance = clearance_of(length(point_m));
    // Somewhere around the pixel, for the point may lie on a slope or at an edge.
    for (int k = 0; k < 9; ++k) {
        ivec2 s = wrapped_in_other(ivec2(position) + ivec2(k % 3, k / 3) - 1);
        float now = clearance_of(texelFetch(main_depth, s, 0).x);
        if (now <= clearance || agree(now, clearance))
            return true;
    }
    return false;
}

void main() {
    ivec2 s = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(s, source_size)))
        return;
    box_radius_m = joins.x;
    tolerance = joins.y;
    float sample_m = texelFetch(source_depth, s, 0).x;
    vec3 point_m = (main_from_source * vec4(min(sample_m, FAR_DISTANCE_M) * direction_of(s), 1.0)).xyz;
    imageStore(depth_still_there, s, vec4(sample_m > 0.0 && is_still_there(point_m) ? sample_m : UNKNOWN));
}
