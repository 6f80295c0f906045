// A vertex of a cluster, to the layer of its view. Depth is near / planar depth: linear on the screen along a plane.
#extension GL_ARB_shader_viewport_layer_array : require

layout(location = 0) in vec3 position;
layout(location = 1) in vec4 row_x;
layout(location = 2) in vec4 row_y;
layout(location = 3) in vec4 row_w;
layout(location = 4) in uvec4 identity;  // item, view, mask
flat out uint item;
#ifdef MASKED
layout(location = 5) in vec2 uv;
out vec2 mask_uv;
flat out uint mask;
#endif

void main() {
    vec4 at = vec4(position, 1.0);
    gl_Position = vec4(dot(row_x, at), dot(row_y, at), NEAR_PLANE_M, dot(row_w, at));
    gl_Layer = int(identity.y);
    gl_ViewportIndex = int(identity.y);
    item = identity.x;
#ifdef MASKED
    mask_uv = uv;
    mask = identity.z;
#endif
}
