// Engine `proxy-sphere`: where the eyes' rays leave a sphere around the source (see source_depth_engine.cpp), in inverse planar depth.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0, r32f) uniform writeonly image2DArray eye_inverse_planar;

#include "eye_rays.glsl"

uniform float radius_m;

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at.xy, imageSize(eye_inverse_planar).xy)))
        return;
    EyeRays eye = eyes[at.z];
    vec3 ray = ray_of(eye, at.xy), from = eye.eye.xyz;
    float along = dot(ray, from), square = dot(ray, ray);
    // Below 0 an eye outside looks past the sphere.
    float under_root = along * along + square * (radius_m * radius_m - dot(from, from));
    float planar_m = under_root < 0.0 ? 0.0 : (sqrt(under_root) - along) / square;
    imageStore(eye_inverse_planar, at, vec4(planar_m > 0.0 ? 1.0 / planar_m : UNKNOWN));
}
