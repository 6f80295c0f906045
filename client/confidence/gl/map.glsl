// How far each pixel can be trusted, 255 times a probability: the risks of reliability.h, weighted and looked up.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform sampler2DArray eye_colour;
layout(binding = 1) uniform usampler2DArray eye_origin;
layout(binding = 3) uniform usampler2DArray surroundings;
layout(binding = 4) uniform usampler2DArray rows;
layout(binding = 5) uniform usampler2DArray fill_depth;
layout(binding = 6) uniform usampler2D shares;  // of TABLE_SIZE entries, a row for each group
layout(binding = 7) uniform sampler2D source_specular;
layout(binding = 0, r8) uniform writeonly image2DArray reliability;

#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "map_numbers.glsl"
#include "map_risks.glsl"

ivec2 size;

struct Around {
    float texture_mean, bend;
    int closeness;
};

Around look_around(ivec3 at) {
    int step = numbers[at.z].reach.x, reach = numbers[at.z].reach.y;
    int left = max(at.x - reach, 0), right = min(at.x + reach, size.x - 1);
    int top = max(at.y - reach, 0), bottom = min(at.y + reach, size.y - 1);
    uint sum = 0u, near = 0u, nearer = 0u, here = 0u;
    for (int y = top; y <= bottom; ++y) {
        uvec2 row = texelFetch(rows, ivec3(at.x, y, at.z), 0).xy;
        int away = abs(y - at.y);
        sum += row.x;
        near |= away <= 2 ? row.y & 256u : 0u;
        nearer |= away <= 1 ? row.y & 512u : 0u;
        here |= away == 0 ? row.y & 1024u : 0u;
    }
    uint bend = texelFetch(rows, at, 0).y & 255u;
    for (int k = -1; k <= 1; k += 2)
        bend = max(bend, texelFetch(rows, ivec3(at.x, clamp(at.y + k * step, 0, size.y - 1), at.z), 0).y & 255u);
    int closeness = (near != 0u ? 1 : 0) + (nearer != 0u ? 1 : 0) + (here != 0u ? 1 : 0);
    return Around(float(sum) / float((right - left + 1) * (bottom - top + 1)), float(bend), closeness);
}

/// Whether the nearest sample of where the source shows what the eye sees is of a mirror.
bool is_mirrored(ivec3 at) {
    EyeRays eye = eyes[at.z];
    vec2 position = position_of(ray_of(eye, at.xy) + inverse_planar(at, size) * eye.eye.xyz);
    ivec2 s = clamp(ivec2(position), ivec2(0), source_size - 1);
    return is_covered(position) && texelFetch(source_specular, s, 0).x > MIN_SPECULAR;
}

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    size = imageSize(reliability).xy;
    if (any(greaterThanEqual(at.xy, size)))
        return;
    EyeNumbers n = numbers[at.z];
    uint origin = texelFetch(eye_origin, at, 0).x;
    if (origin == ORIGIN_GAP) {
        imageStore(reliability, at, vec4(0.0));
        return;
    }
    Around around = look_around(at);
    float risks[RISKS];
    risks[RISK_TEXTURE] = log_of(0.5 * around.texture_mean);
    float kept = kept_share(visible_loss(risks[RISK_TEXTURE]));
    if (origin == ORIGIN_SOURCE && n.more.y != 0.0) {
        imageStore(reliability, at, vec4(kept));
        return;
    }
    vec3 colour = texelFetch(eye_colour, at, 0).rgb;
    float contrast = float(texelFetch(surroundings, at, 0).x);
    risks[RISK_CONTRAST] = log_of(0.5 * contrast);
    risks[RISK_DETAIL] = log_of(0.5 * around.bend);
    float parallax_px = 0.0;
    if (n.reach.z != 0)
        parallax_px = add_shape(at, size, risks);
    else
        add_flat(at, risks);
    bool mirrored = n.reach.w != 0 && origin == ORIGIN_SOURCE && is_mirrored(at);
    risks[RISK_SILHOUETTE_0] = around.closeness >= 3 ? 1.0 : 0.0;
    risks[RISK_SILHOUETTE_1] = around.closeness >= 2 ? 1.0 : 0.0;
    risks[RISK_SILHOUETTE_2] = around.closeness >= 1 ? 1.0 : 0.0;
    risks[RISK_SPECULAR] = mirrored ? log_of(0.5 * contrast * min(1.0, parallax_px)) : 0.0;
    risks[RISK_DEPTH_ERROR] = log_of(n.eye.z * contrast);
    risks[RISK_OUTSIDE] = n.eye.y;
    risks[RISK_FILL_DEPTH] = origin == ORIGIN_SOURCE ? 0.0 : log_of(float(texelFetch(fill_depth, at, 0).x));
    risks[RISK_BRIGHTNESS] = max(colour.r, max(colour.g, colour.b));
    int group = mirrored ? GROUP_MIRRORED : n.group_of_origin[origin / 4u][origin % 4u];
    float entry = min(weighted_sum(group, risks) * ENTRIES_PER_UNIT, float(TABLE_SIZE - 1));
    float share = float(texelFetch(shares, ivec2(int(entry), group), 0).x) / 255.0;
    imageStore(reliability, at, vec4(share * kept));
}
