// What holds for whole pictures: RiskNumbers (reliability.h) of each eye, and what is the same for all.

struct EyeNumbers {
    vec4 centre;   // of the source in the eye's axes, metres; and its distance
    vec4 pole;     // of the source's rows in the eye's axes; and source pixels per radian over the eye's at its middle
    vec4 eye;      // focal length in pixels, radii outside the box, depth_error_px, min_step_inverse_m
    vec4 more;     // log2 of that density; 1 where the eye's view is the source's
    ivec4 reach;   // a source pixel in the eye's, texture_reach, whether depth is known, whether mirrors count
    ivec4 group_of_origin[3];  // RiskGroup of each PixelOrigin
};

layout(std140, binding = 2) uniform MapNumbers {
    EyeNumbers numbers[MAX_EYES];
    vec4 weights[4 * RISK_GROUPS];  // of each group, in the order of Risk, zeros after them
    vec4 losses[2];                 // loss_at of LOSS_TEXTURES
};

layout(binding = 2) uniform sampler2DArray eye_depth;
uniform float inverse_depth_scale;  // of its samples

/// 1 / planar depth; 0 for a miss and where there is no depth. Pixels outside repeat the border's.
float inverse_planar(ivec3 at, ivec2 size) {
    float z = inverse_depth_scale * texelFetch(eye_depth, ivec3(clamp(at.xy, ivec2(0), size - 1), at.z), 0).x;
    return z > 0.0 ? min(z, MAX_INVERSE_M) : 0.0;
}
