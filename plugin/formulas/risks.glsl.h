// What puts a pixel at risk (reliability.h), by the surface that it shows.

CONSTANT float max_halvings = 4.0f;
CONSTANT float min_cosine2 = 1e-6f;
CONSTANT float min_facing = 1e-3f;
CONSTANT float min_distance2 = 1e-6f;
/// So that the normal of what is infinitely far divides by something.
CONSTANT float min_length2 = 1e-30f;
/// What log2 is above a straight line from power to power, over the product of the fractions to either side.
CONSTANT float log2_correction = 0.346607f;

/// log2 within 0.01 for x > 0, rising wherever x does: a straight line from power to power would err by
/// 0.09, its quadratic correction leaves a tenth of that.
FORMULA Number fast_log2(Number x) {
    Number f = mantissa_of(x) - 1.0f;
    return log2_correction * f * (1.0f - f) + (exponent_of(x) + f);
}

FORMULA Number log_of(Number x) {
    return fast_log2(1.0f + x);
}

/// Noise, denoising and coding put such a share of the source's pixels visibly off. A pixel that would be good without
/// them is good so often. That is less than one less the share: they harm most where geometry is hard.
FORMULA Number kept_share(Number lost) {
    return (1.0f - lost) * (1.0f - 0.3f * lost);
}

/// The smaller step to a neighbour: the other one may lead across an edge.
FORMULA Number believed_step(Number before, Number here, Number after) {
    Number a = here - before;
    Number b = after - here;
    return select(abs(a) <= abs(b), a, b);
}

/// Whether inverse depth steps between b and c more than the slopes beside the step explain.
FORMULA Truth is_step(Number a, Number b, Number c, Number d, float least) {
    Number step = abs(c - b);
    return both(step > least, step > 2.0f * max(abs(b - a), abs(d - c)));
}

FORMULA Number clamped_halvings(Number halvings) {
    return min(max(halvings, 0.0f), max_halvings);
}

/// Of a whole picture: the source's centre and the pole of its rows in the eye's axes (0 where its columns
/// do not converge), and source pixels per radian over the eye's at its middle.
struct SourceSeen {
    float centre_x;
    float centre_y;
    float centre_z;
    float pole_x;
    float pole_y;
    float pole_z;
    float density;
};

/// Of a pixel: halvings of detail, and 1 / distance in 1 / m.
struct SurfaceRisks {
    Number blur;
    Number minification;
    Number grazing;
    Number inverse_m;
};

/// `a` and `b` are the pixel's ray over its planar depth, to the right and up; `q` is 1 / planar depth; `nx`
/// and `ny` are its slopes along a and b.
FORMULA SurfaceRisks surface_risks(Number a, Number b, Number q, Number nx, Number ny, SourceSeen seen) {
    Number nz = nx * a + ny * b - q;
    Number length2 = a * a + b * b + 1.0f;
    Number over_length = over_sqrt(length2);
    Number cosine2 = q * q / ((nx * nx + ny * ny + nz * nz) * length2 + min_length2);
    Number inverse_m = q * over_length;
    // Of the point over its distance from the eye, so that misses need no case of their own.
    Number sx = a * over_length - seen.centre_x * inverse_m;
    Number sy = b * over_length - seen.centre_y * inverse_m;
    Number sz = -(seen.centre_z * inverse_m + over_length);
    Number nearer = over_sqrt(max(sx * sx + sy * sy + sz * sz, min_distance2));
    Number facing = abs(1.0f - seen.centre_x * nx - seen.centre_y * ny - seen.centre_z * nz);
    Number denser = seen.density * over_length * nearer;
    Number doublings = 0.5f * fast_log2(denser * denser * over_length * nearer * max(facing, min_facing));
    Number sine = (seen.pole_x * sx + seen.pole_y * sy + seen.pole_z * sz) * nearer;
    Number closer = -0.5f * fast_log2(max(1.0f - sine * sine, min_cosine2));
    Number aslant = select(q > 0.0f, -0.5f * fast_log2(max(cosine2, min_cosine2)), 0.0f);
    SurfaceRisks risks;
    risks.blur = 0.5f * (clamped_halvings(-doublings) + clamped_halvings(-doublings - closer));
    risks.minification = clamped_halvings(doublings);
    risks.grazing = clamped_halvings(aslant);
    risks.inverse_m = inverse_m;
    return risks;
}
