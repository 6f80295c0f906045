// Planes of one eye's picture into textures of a host, a part of them: what gave each pixel its colour, its depth along
// the ray in metres, and how far it can be trusted. What the host has not bound is not written.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 1) uniform usampler2DArray eye_origin;
layout(binding = 2) uniform sampler2DArray eye_depth;
layout(binding = 3) uniform sampler2DArray eye_confidence;
layout(binding = 0, r8ui) uniform writeonly uimage2D origin;
layout(binding = 1, r32f) uniform writeonly image2D depth_m;
layout(binding = 2, r8) uniform writeonly image2D confidence;

uniform ivec3 first;  // column and row of the part, and the eye
uniform ivec2 part_size;
uniform vec3 camera;                // focal length, width and height in pixels
uniform float inverse_depth_scale;  // of eye_depth's samples: inverse planar depth in 1 / m; 0: it is not known

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at, part_size)))
        return;
    ivec3 from = ivec3(first.xy + at, first.z);
    imageStore(origin, at, texelFetch(eye_origin, from, 0));
    imageStore(confidence, at, texelFetch(eye_confidence, from, 0));
    vec2 along = (vec2(from.xy) + 0.5 - 0.5 * camera.yz) / camera.x;
    float z = inverse_depth_scale * texelFetch(eye_depth, from, 0).x;
    float ray_m = z > 0.0 ? sqrt(1.0 + dot(along, along)) / z : INFINITE;
    imageStore(depth_m, at, vec4(inverse_depth_scale == 0.0 || isnan(z) ? UNKNOWN : ray_m));
}
