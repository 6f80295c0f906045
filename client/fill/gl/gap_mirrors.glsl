// How far behind the surface of a mirror that a gap pixel sees its image lies, by the sample of a picture with a mask
// that has most of that surface: as Mirrors of gap_resample.cpp has it.
layout(local_size_x = 256) in;

layout(binding = 1) uniform sampler2D source_depth;
layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 0, rgba8) uniform readonly image2DArray eye_colour;
layout(binding = 2, r32f) uniform writeonly image2DArray image_behind;

#include "listed_gap.glsl"
#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "eye_surface.glsl"
#include "gap_surface.glsl"
#include "mirror_planes.glsl"

void main() {
    ivec3 at;
    if (!listed_gap(at))
        return;
    EyeRays eye = eyes[at.z];
    box_radius_m = eye.agreement.x;
    tolerance = eye.agreement.y;
    Taps taps;
    vec4 weights = weights_of_surface(at, eye, taps);
    int most = 0;
    for (int k = 1; k < 4; ++k)
        most = weights[k] > weights[most] ? k : most;
    ivec2 s = taps.samples[most];
    // Infinitely far behind: there is no mirror, or nothing is known of one.
    float behind_m = INFINITE;
    if (weights != NONE && is_specular(s))
        behind_m = image_of(s) - texelFetch(source_depth, s, 0).x;
    imageStore(image_behind, at, vec4(behind_m));
}
