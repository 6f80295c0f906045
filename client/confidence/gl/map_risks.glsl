// A pixel's risks and what they sum up to.
#include "risks.glsl.h"

/// What the surface's shape puts at risk. `risks` has detail already; returns parallax in pixels.
float add_shape(ivec3 at, ivec2 size, inout float risks[RISKS]) {
    EyeNumbers n = numbers[at.z];
    float focal_px = n.eye.x, detail = risks[RISK_DETAIL];
    vec2 ab = vec2(at.x + 0.5 - 0.5 * size.x, 0.5 * size.y - at.y - 0.5) / focal_px;
    float q = inverse_planar(at, size);
    float across = believed_step(inverse_planar(at - ivec3(1, 0, 0), size), q,
                                 inverse_planar(at + ivec3(1, 0, 0), size));
    float down = believed_step(inverse_planar(at - ivec3(0, 1, 0), size), q,
                               inverse_planar(at + ivec3(0, 1, 0), size));
    SourceSeen seen = SourceSeen(n.centre.x, n.centre.y, n.centre.z, n.pole.x, n.pole.y, n.pole.z, n.pole.w);
    SurfaceRisks surface = surface_risks(ab.x, ab.y, q, focal_px * across, -focal_px * down, seen);
    risks[RISK_BLUR] = detail * surface.blur;
    risks[RISK_MINIFICATION] = detail * surface.minification;
    risks[RISK_GRAZING] = detail * surface.grazing;
    float parallax_px = focal_px * n.centre.w * surface.inverse_m;
    risks[RISK_PARALLAX] = log_of(parallax_px);
    return parallax_px;
}

/// Without depth nothing is known of the surface: it is taken to face the eye, a metre away.
void add_flat(ivec3 at, inout float risks[RISKS]) {
    float doublings = numbers[at.z].more.x;
    risks[RISK_BLUR] = risks[RISK_DETAIL] * clamped_halvings(-doublings);
    risks[RISK_MINIFICATION] = risks[RISK_DETAIL] * clamped_halvings(doublings);
    risks[RISK_GRAZING] = 0.0;
    risks[RISK_PARALLAX] = log_of(numbers[at.z].eye.x * numbers[at.z].centre.w);
}

/// loss_at (visible_loss.h), as a sum of lines each of which rises over one stretch of texture only.
float visible_loss(float texture_here) {
    const float textures[] = LOSS_TEXTURES;
    float loss = losses[0][0];
    for (int i = 0; i + 1 < textures.length(); ++i) {
        float along = clamp((texture_here - textures[i]) / (textures[i + 1] - textures[i]), 0.0, 1.0);
        loss += along * (losses[(i + 1) / 4][(i + 1) % 4] - losses[i / 4][i % 4]);
    }
    return loss;
}

float weighted_sum(int group, float risks[RISKS]) {
    float sum = 0.0;
    for (int k = 0; k < RISKS; ++k)
        sum += weights[4 * group + k / 4][k % 4] * risks[k];
    return sum;
}
