// One cluster of one instance and one view: draws it unless the view's pyramid lies beside its ball.
layout(local_size_x = 64) in;

#include "depth_views.glsl"
#include "geometry.glsl"

struct Command {
    uint count, instances, first_index, base_vertex, base_instance;
};

layout(std430, binding = 2) writeonly buffer Opaque {
    Command opaque_commands[];
};
layout(std430, binding = 3) writeonly buffer Masked {
    Command masked_commands[];
};
layout(std430, binding = 4) buffer Counts {
    uint opaque_count, masked_count, triangles;
};

// By which an instance's transform may make lengths grow.
layout(std430, binding = 5) readonly buffer Growth {
    float growth[];
};

uniform int item_count;
uniform int view_count;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= uint(item_count))
        return;
    Item item = items[index];
    vec3 at = (world_from_object[item.instance] * vec4(item.ball.xyz, 1.0)).xyz;
    float radius = item.ball.w * growth[item.instance];
    for (int view = 0; view < view_count; ++view) {
        vec3 seen = (views[view].view_from_world * vec4(at, 1.0)).xyz;
        bool drawn = -seen.z > -radius;
        for (int plane = 0; plane < 4; ++plane)
            drawn = drawn && dot(views[view].planes[plane].xyz, seen) > -radius;
        if (!drawn)
            continue;
        Command command = Command(item.index_count, 1u, item.first_index, 0u, index * MOST_VIEWS + uint(view));
        atomicAdd(triangles, item.index_count / 3u);
        if (item.masked == 0u)
            opaque_commands[atomicAdd(opaque_count, 1u)] = command;
        else
            masked_commands[atomicAdd(masked_count, 1u)] = command;
    }
}
