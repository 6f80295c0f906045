// A vertex of a cluster, to the layer of its view. Depth is near / planar depth: linear on the screen along a plane.
#extension GL_ARB_shader_viewport_layer_array : require

#include "depth_views.glsl"
#include "geometry.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in uint item_and_view;
flat out uint item;
#ifdef MASKED
#include "masks.glsl"

layout(location = 2) in vec2 uv;
out vec2 mask_uv;
flat out uint mask;
#endif

void main() {
    uint view = item_and_view % MOST_VIEWS;
    item = item_and_view / MOST_VIEWS;
    uint instance = items[item].instance;
    vec4 seen = views[view].view_from_world * (world_from_object[instance] * vec4(position, 1.0));
    vec4 scale = views[view].scale;
    gl_Position = vec4(seen.xy * scale.xy, scale.z, -seen.z);
    gl_Layer = int(view);
    gl_ViewportIndex = int(view);
#ifdef MASKED
    mask_uv = uv;
    mask = mask_of_instance[instance];
#endif
}
