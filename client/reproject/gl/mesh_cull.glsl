// A draw of each block of a mesh (mesh_lists.glsl) for each eye that may see something of it: SeenThrough of
// eye_projection.h.
layout(local_size_x = 64) in;

#include "eye_rays.glsl"
#include "mesh_lists.glsl"

layout(std430, binding = 2) writeonly buffer MeshDraws {
    Draw draws[];
};

uniform int block_count;
uniform int eye_count;
uniform vec2 eye_size;

vec3 corner_ray(EyeRays eye, vec2 corner) {
    vec2 at = corner * eye_size - 0.5;
    return eye.corner.xyz + at.x * eye.right.xyz + at.y * eye.down.xyz;
}

bool may_show(EyeRays eye, MeshBlock block) {
    const vec2 corners[5] = vec2[5](vec2(0.0), vec2(1.0, 0.0), vec2(1.0), vec2(0.0, 1.0), vec2(0.0));
    float sine_of_radius = sqrt(max(1.0 - block.cone.w * block.cone.w, 0.0));
    bool shown = true;
    for (int i = 0; i < 4; ++i) {
        vec3 inwards = normalize(cross(corner_ray(eye, corners[i]), corner_ray(eye, corners[i + 1])));
        // The largest inwards . q over the block's cone, less the smallest k inwards . eye.
        float cosine = dot(inwards, block.cone.xyz), sine = sqrt(max(1.0 - cosine * cosine, 0.0));
        float largest = cosine >= block.cone.w ? 1.0 : cosine * block.cone.w + sine * sine_of_radius;
        vec2 of_eye = dot(inwards, eye.eye.xyz) * block.inverses;
        shown = shown && largest - min(of_eye.x, of_eye.y) >= -1e-5;
    }
    return shown;
}

void main() {
    if (gl_GlobalInvocationID.x >= uint(block_count))
        return;
    MeshBlock block = blocks[gl_GlobalInvocationID.x];
    if (block.index_count == 0u)
        return;
    for (int eye = 0; eye < eye_count; ++eye)
        if (may_show(eyes[eye], block))
            draws[atomicAdd(draw_count, 1u)] = Draw(block.index_count, 1u, block.first_index, 0u, uint(eye));
}
