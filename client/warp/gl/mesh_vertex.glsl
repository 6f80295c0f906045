// A point of a mesh (mesh_lists.glsl) as one of the eyes sees it. Depth is near / planar depth: linear on the screen
// along a plane.
#extension GL_ARB_shader_viewport_layer_array : require

uniform vec2 eye_size;

layout(location = 0) in vec4 point;  // (q, k)
layout(location = 1) in uint eye_number;
out float point_inverse;  // k: its perspective interpolation over the point's planar depth is 1 / planar depth

#include "eye_rays.glsl"

void main() {
    EyeRays eye = eyes[eye_number];
    vec3 seen = (point.xyz - point.w * eye.eye.xyz) * mat3(eye.source_from_eye);
    float ahead = -seen.z;
    vec2 across = eye.view.x * vec2(seen.x, -seen.y) + (eye.view.yz + 0.5) * ahead;
    gl_Position = vec4(2.0 * across / eye_size - ahead, NEAR_PLANE_M * point.w, ahead);
#ifndef GL_ES
    gl_Layer = int(eye_number);
#endif
    point_inverse = point.w;
}
