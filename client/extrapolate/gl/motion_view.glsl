// How what each pixel of an eye sees moves across its view: radians a second to the right and down, 1; or 0, 0, 0.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform usampler2D region_map;
layout(binding = 2) uniform sampler2DArray eye_depth;
layout(binding = 0, rgba16f) uniform writeonly image2DArray motion;

#include "extrapolate_regions.glsl"
#include "eye_rays.glsl"

// By how much of it a surface may be nearer or farther than its region says: it has moved since.
const float DEPTH_TOLERANCE = 1.25;

uniform int has_depth;
uniform float inverse_depth_scale;

/// Where a pixel's surface is, and whose it is, if it is one that moves.
bool find_moving(ivec3 at, EyeRays eye, out vec3 point, out uint region) {
    float z = has_depth != 0 ? inverse_depth_scale * texelFetch(eye_depth, at, 0).x : 0.0;
    if (has_depth != 0 && (isnan(z) || z <= 0.0))
        return false;
    vec3 d = ray_of(eye, at.xy) + z * eye.eye.xyz;
    vec2 position = position_of(d);
    if (!is_covered(position))
        return false;
    region = texelFetch(region_map, wrapped(ivec2(floor(position))), 0).x;
    if (region == 0u)
        return false;
    vec2 depths = regions[region - 1u].depths.xy;
    float distance_m = has_depth != 0 ? length(d) / z : 0.5 * (depths.x + depths.y);
    point = distance_m * normalize(d);
    // Else it stands before or behind what the source sees there.
    return distance_m > depths.x / DEPTH_TOLERANCE && distance_m < depths.y * DEPTH_TOLERANCE;
}

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at, imageSize(motion))))
        return;
    EyeRays eye = eyes[at.z];
    vec3 point;
    uint region;
    vec4 seen = vec4(0.0);
    if (find_moving(at, eye, point, region)) {
        vec3 velocity = regions[region - 1u].velocity.xyz + cross(regions[region - 1u].turning.xyz, point);
        vec3 from_eye = has_depth != 0 ? point - eye.eye.xyz : point;
        vec3 across = (velocity - dot(velocity, from_eye) / dot(from_eye, from_eye) * from_eye) / length(from_eye);
        seen = vec4(dot(across, normalize(eye.right.xyz)), dot(across, normalize(eye.down.xyz)), 1.0, 0.0);
    }
    imageStore(motion, at, seen);
}
