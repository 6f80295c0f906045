// One cluster of one instance, for every view: draws it where the view may see something of it. Hidden ones are found in
// two rounds (after Haar and Aaltonen 2015, "GPU-driven rendering pipelines"): what was seen last is drawn first, and of
// the rest what lies nearer than the farthest depth around it. What is not drawn could not be seen.
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
    uint record_count, triangles, opaque_count[2], masked_count[2];
};

// By which an instance's transform may make lengths grow.
layout(std430, binding = 5) readonly buffer Growth {
    float growth[];
};

// Views that saw something of an item when it was last asked, a bit each.
layout(std430, binding = 6) buffer Seen {
    uint seen_by[];
};

// What a draw's vertices need to know, which is the same for all of them.
struct DrawRecord {
    vec4 x, y, w;    // rows of the matrix from the mesh to the view's clip space
    uvec4 identity;  // item, view, mask, nothing
};
layout(std430, binding = 7) writeonly buffer Records {
    DrawRecord records[];
};
layout(std430, binding = 8) readonly buffer InstanceMasks {
    uint mask_of_instance[];
};

layout(binding = 0) uniform sampler2DArray pyramid;

uniform int item_count;
uniform int view_count;
uniform int max_draws;  // of a round
uniform int round;
uniform int culling;

// Depth is rounded once as it is drawn and once here.
const float rounding = 1.0 + 1e-5;

bool in_pyramid_of(DepthView view, vec3 seen, float radius) {
    bool inside = -seen.z > -radius;
    for (int plane = 0; plane < 4; ++plane)
        inside = inside && dot(view.planes[plane].xyz, seen) > -radius;
    return inside;
}

/// Whether all that the ball covers is known to be nearer than it. What it covers is taken from the box around it.
bool is_hidden(int layer, DepthView view, vec3 seen, float radius) {
    float nearest = -seen.z - radius, farthest = -seen.z + radius;
    if (nearest <= NEAR_PLANE_M)
        return false;
    vec2 low = seen.xy - radius, high = seen.xy + radius;
    low /= mix(vec2(farthest), vec2(nearest), lessThan(low, vec2(0.0)));
    high /= mix(vec2(nearest), vec2(farthest), lessThan(high, vec2(0.0)));
    vec2 a = (low * view.scale.xy * 0.5 + 0.5) * view.size.xy, b = (high * view.scale.xy * 0.5 + 0.5) * view.size.xy;
    vec2 last = view.size.xy - 1.0;
    ivec2 first_block = ivec2(clamp(min(a, b), vec2(0.0), last)) / PYRAMID_BLOCK;
    ivec2 last_block = ivec2(clamp(max(a, b), vec2(0.0), last)) / PYRAMID_BLOCK;
    int level = 0;
    while (any(greaterThan((last_block >> level) - (first_block >> level), ivec2(1))))
        ++level;
    first_block >>= level;
    last_block >>= level;
    float covered = texelFetch(pyramid, ivec3(first_block, layer), level).x;
    covered = min(covered, texelFetch(pyramid, ivec3(last_block, layer), level).x);
    covered = min(covered, texelFetch(pyramid, ivec3(first_block.x, last_block.y, layer), level).x);
    covered = min(covered, texelFetch(pyramid, ivec3(last_block.x, first_block.y, layer), level).x);
    return rounding * NEAR_PLANE_M / nearest < covered;
}

void draw(uint index, Item item, uint view) {
    uint slot = atomicAdd(record_count, 1u);
    mat4 rows = transpose(views[view].view_from_world * world_from_object[item.instance]);
    records[slot] = DrawRecord(views[view].scale.x * rows[0], views[view].scale.y * rows[1], -rows[2],
                               uvec4(index, view, mask_of_instance[item.instance], 0u));
    Command command = Command(item.index_count, 1u, item.first_index, 0u, slot);
    atomicAdd(triangles, item.index_count / 3u);
    uint first = uint(round * max_draws);
    if (item.masked == 0u)
        opaque_commands[first + atomicAdd(opaque_count[round], 1u)] = command;
    else
        masked_commands[first + atomicAdd(masked_count[round], 1u)] = command;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= uint(item_count))
        return;
    Item item = items[index];
    vec3 at = (world_from_object[item.instance] * vec4(item.ball.xyz, 1.0)).xyz;
    float radius = item.ball.w * growth[item.instance];
    uint before = culling == CULL_HIDDEN ? seen_by[index] : 0u, now = 0u;
    for (int view = 0; view < view_count; ++view) {
        vec3 seen = (views[view].view_from_world * vec4(at, 1.0)).xyz;
        if (culling != CULL_NOTHING && !in_pyramid_of(views[view], seen, radius))
            continue;
        bool drawn_first = culling != CULL_HIDDEN || (before >> view & 1u) != 0u;
        if (round == 0) {
            if (drawn_first)
                draw(index, item, uint(view));
        } else if (!is_hidden(view, views[view], seen, radius)) {
            now |= 1u << view;
            if (!drawn_first)
                draw(index, item, uint(view));
        }
    }
    if (round == 1)
        seen_by[index] = now;
}
