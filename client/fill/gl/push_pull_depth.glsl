// w = B / (r - B) of a pixel (depth_agreement.h); 0, the background, where nothing is known of its depth.
#include "agreement.glsl.h"
#include "eye_rays.glsl"

layout(binding = 2) uniform sampler2DArray eye_depth;
uniform float inverse_depth_scale;  // of its samples; 0: all depths are alike

/// Of a sample of eye_depth.
float w_of(float sample_there, ivec3 at) {
    if (inverse_depth_scale == 0.0)
        return 0.0;
    float z = inverse_depth_scale * sample_there, box_radius_m = eyes[at.z].agreement.x;
    vec2 aside = (vec2(at.xy) - eyes[at.z].view.yz) / eyes[at.z].view.x;
    float inverse_m = z * inversesqrt(1.0 + dot(aside, aside));
    return z > 0.0 ? box_radius_m * inverse_m / share_beyond_box(inverse_m, box_radius_m) : 0.0;
}

float w_at(ivec3 at) {
    return w_of(texelFetch(eye_depth, at, 0).x, at);
}
