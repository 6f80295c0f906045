// A pixel's risks and what they sum up to: the formulas of map_kernels.cpp.

float fast_log2(float x) {
    int bits = floatBitsToInt(x);
    float exponent = float((bits >> 23) - 127), f = intBitsToFloat((bits & 0x007fffff) | 0x3f800000) - 1.0;
    return exponent + f + LOG2_CORRECTION * f * (1.0 - f);
}

float log_of(float x) {
    return fast_log2(1.0 + x);
}

float believed_slope(float before, float here, float after) {
    float a = here - before, b = after - here;
    return abs(a) <= abs(b) ? a : b;
}

/// What the surface's shape puts at risk. `risks` has detail already; returns parallax in pixels.
float add_shape(ivec3 at, ivec2 size, inout float risks[RISKS]) {
    EyeNumbers n = numbers[at.z];
    float focal_px = n.eye.x, density = n.pole.w, detail = risks[RISK_DETAIL];
    vec2 ab = vec2(at.x + 0.5 - 0.5 * size.x, 0.5 * size.y - at.y - 0.5) / focal_px;
    float q = inverse_planar(at, size);
    float nx = focal_px * believed_slope(inverse_planar(at - ivec3(1, 0, 0), size), q,
                                         inverse_planar(at + ivec3(1, 0, 0), size));
    float ny = -focal_px * believed_slope(inverse_planar(at - ivec3(0, 1, 0), size), q,
                                          inverse_planar(at + ivec3(0, 1, 0), size));
    vec3 normal = vec3(nx, ny, nx * ab.x + ny * ab.y - q);
    float length2 = 1.0 + dot(ab, ab), over_length = inversesqrt(length2);
    float cosine2 = q * q / (dot(normal, normal) * length2 + MIN_LENGTH2);
    float inverse_r = q * over_length;
    // Of the point over its distance from the eye, so that misses need no case of their own.
    vec3 s = vec3(ab, -1.0) * over_length - n.centre.xyz * inverse_r;
    float nearer = inversesqrt(max(dot(s, s), MIN_DISTANCE2));
    float facing = abs(1.0 - dot(normal, n.centre.xyz)), denser = density * over_length * nearer;
    float doublings = 0.5 * fast_log2(denser * denser * over_length * nearer * max(facing, MIN_FACING));
    float halvings_of_cosine = q > 0.0 ? -0.5 * fast_log2(max(cosine2, MIN_COSINE2)) : 0.0;
    float sine = dot(n.pole.xyz, s) * nearer;
    float closer = -0.5 * fast_log2(max(1.0 - sine * sine, MIN_COSINE2));
    risks[RISK_BLUR] = detail * 0.5 *
                       (clamp(-doublings, 0.0, MAX_HALVINGS) + clamp(-doublings - closer, 0.0, MAX_HALVINGS));
    risks[RISK_MINIFICATION] = detail * clamp(doublings, 0.0, MAX_HALVINGS);
    risks[RISK_GRAZING] = detail * clamp(halvings_of_cosine, 0.0, MAX_HALVINGS);
    float parallax_px = focal_px * n.centre.w * inverse_r;
    risks[RISK_PARALLAX] = log_of(parallax_px);
    return parallax_px;
}

/// Without depth nothing is known of the surface: it is taken to face the eye, a metre away.
void add_flat(ivec3 at, inout float risks[RISKS]) {
    float doublings = numbers[at.z].more.x;
    risks[RISK_BLUR] = risks[RISK_DETAIL] * clamp(-doublings, 0.0, MAX_HALVINGS);
    risks[RISK_MINIFICATION] = risks[RISK_DETAIL] * clamp(doublings, 0.0, MAX_HALVINGS);
    risks[RISK_GRAZING] = 0.0;
    risks[RISK_PARALLAX] = log_of(numbers[at.z].eye.x * numbers[at.z].centre.w);
}

/// loss_at (coding_loss.h), as a sum of lines each of which rises over one stretch of texture only.
float coding_loss(float texture_here) {
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
        sum += weights[(group * RISKS + k) / 4][k % 4] * risks[k];
    return sum;
}
