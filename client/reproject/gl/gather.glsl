// Engine `gather`: where each ray of an eye meets the source's surface, as gather.cpp finds it: fixed points from
// several seeds, the nearest of them kept if nothing lies before it, else the first place where the ray goes in. A work
// group has a tile of an eye's pixels.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0, r32f) uniform writeonly image2DArray eye_inverse_planar;
uniform vec2 finding;  // sine of the share of the budget that finding may use up, and the angle of a source's pixel

#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "source_lattice.glsl"
#include "source_block.glsl"

const int INVOCATIONS = GROUP_WIDTH * GROUP_HEIGHT;
const float NOTHING_FOUND = -1.0;

EyeRays eye;
float eye_square;
float down_longer;
float budget;  // the whole one
shared float tile_nearest[INVOCATIONS], tile_farthest[INVOCATIONS];

// A ray by s = 1 / planar depth: the point at s lies in the direction ray + s eye, s / |ray + s eye| from the source.
vec3 ray;
float ray_square, along_eye;

vec3 at(float s) {
    return ray + s * eye.eye.xyz;
}

float inverse_distance(float s) {
    return s / length(at(s));
}

/// Where the ray leaves the sphere of radius 1 / k around the source; the largest number if it never does.
float leaves(float k) {
    float kk = k * k, a = 1.0 - kk * eye_square, b = kk * along_eye;
    float root = sqrt(max(b * b + a * kk * ray_square, 0.0));
    return a > 0.0 ? (b + root) / a : LARGEST;
}

bool is_found(float a, float b) {
    tolerance = finding.x;
    bool found = same_inverse(a, b);
    tolerance = budget;
    return found;
}

float sample_inverse(ivec2 p) {
    return is_sample(p) ? inverse_of_sample(lattice_wrapped(p)) : UNKNOWN;
}

bool connected(ivec2 p, ivec2 step) {
    return are_joined(sample_inverse(p - step), sample_inverse(p), sample_inverse(p + step), sample_inverse(p + 2 * step));
}

bool is_joined_square(ivec2 p) {
    const ivec2 RIGHT = ivec2(1, 0), DOWN = ivec2(0, 1);
    return connected(p, RIGHT) && connected(p + DOWN, RIGHT) && connected(p, DOWN) && connected(p + RIGHT, DOWN);
}

float slope(ivec2 p, ivec2 step, float towards) {
    bool before = connected(p - step, step), after = connected(p, step);
    float here = sample_inverse(p);
    if (after && (towards > 0.0 || !before))
        return sample_inverse(p + step) - here;
    return before ? here - sample_inverse(p - step) : 0.0;
}

/// Half the square of the chord between neighbours of a row.
float across_longer(int row) {
    ivec2 p = ivec2(source_size.x / 2, clamp(row, 0, source_size.y - 1));
    vec3 chord = lattice_direction(p + ivec2(1, 0)) - lattice_direction(p);
    return 0.5 * dot(chord, chord);
}

/// The surface at any position: bilinear in 1/r where the four samples around are joined, else the nearest sample's own
/// plane. NaN outside the picture.
float surface_inverse(vec3 direction) {
    vec2 p = position_of(direction) - 0.5;
    if (!is_covered(p + 0.5))
        return UNKNOWN;
    ivec2 s = ivec2(floor(p));
    vec2 w = p - floor(p);
    vec4 k = vec4(sample_inverse(s), sample_inverse(s + ivec2(1, 0)), sample_inverse(s + ivec2(0, 1)), sample_inverse(s + 1));
    float low = min(min(k.x, k.y), min(k.z, k.w)), high = max(max(k.x, k.y), max(k.z, k.w));
    bool all_known = k.x + k.y + k.z + k.w >= 0.0;
    if (all_known && (same_inverse(low, high) || is_joined_square(s))) {
        // Between samples their directions' mean is shorter than 1, and what it is to be divided by.
        float longer = 1.0 + w.x * (1.0 - w.x) * across_longer(s.y) + w.y * (1.0 - w.y) * down_longer;
        return mix(mix(k.x, k.y, w.x), mix(k.z, k.w, w.x), w.y) * longer;
    }
    ivec2 own = s + ivec2(greaterThan(w, vec2(0.5)));
    vec2 by = p - vec2(own);
    float k_own = sample_inverse(own);
    k_own += by.x * slope(own, ivec2(1, 0), by.x) + by.y * slope(own, ivec2(0, 1), by.y);
    return isnan(k_own) ? UNKNOWN : max(k_own, 0.0);
}

/// Of the nearest sample: quick, for signs only.
float nearest_inverse(vec3 direction) {
    vec2 p = position_of(direction);
    return is_covered(p) ? sample_inverse(ivec2(floor(p))) : UNKNOWN;
}

/// Pixels of the source between two points of the ray: never fewer than there are.
float arc(float s, float other) {
    vec3 a = at(s), b = at(other);
    return fast_atan2(length(cross(a, b)), dot(a, b)) / finding.y;
}

/// The fixed point of s -> where the ray leaves the sphere that the surface in the direction of s lies on, with
/// Aitken's extrapolation.
float converge(float s) {
    float last = s, last_but_one = s;
    for (int i = 0; i < 6; ++i) {
        float k = surface_inverse(at(s));
        if (isnan(k))
            return NOTHING_FOUND;
        float next = leaves(k);
        if (is_found(inverse_distance(s), k))
            return next;
        last_but_one = last;
        last = s;
        s = next;
        if (i % 3 == 1) {
            float bend = s - 2.0 * last + last_but_one;
            float extrapolated = last_but_one - (last - last_but_one) * (last - last_but_one) / bend;
            s = extrapolated >= 0.0 ? extrapolated : s;
        }
    }
    return NOTHING_FOUND;
}

/// From the eye outwards to s: the last place before anything of the source's; s if there is nothing.
float last_before_anything(float s, float near) {
    int steps = int(arc(s, near));
    float before = near;
    for (int i = steps; i >= 1; --i) {
        float here = s + (near - s) * float(i) / float(steps + 1);
        float k = nearest_inverse(at(here)), of_ray = inverse_distance(here);
        if (k > of_ray && !same_inverse(k, of_ray))
            return before;
        before = here;
    }
    return s;
}

/// In front at `near`, behind at `far`. A jump between two surfaces is no crossing.
float bisect(float near, float far) {
    for (int i = 0; i < 24; ++i) {
        float s = 0.5 * (near + far), k = surface_inverse(at(s)), of_ray = inverse_distance(s);
        if (k >= 0.0 && is_found(of_ray, k))
            return leaves(k);
        if (k >= of_ray)
            far = s;
        else
            near = s;
    }
    return NOTHING_FOUND;
}

/// From `from`, before everything, outwards in steps of a quarter of a pixel: the first place where the ray goes in.
float scan(float far, float from, float arc_px) {
    int steps = int(arc_px / 0.25) + 2;
    float before = from * (1.0 + 1e-5) + 1e-9;
    bool in_front = true;
    for (int i = 0; i <= steps; ++i) {
        float s = from + (far * (1.0 - 1e-5) - from) * float(i) / float(steps);
        float k = surface_inverse(at(s));
        bool now_in_front = isnan(k) || k < inverse_distance(s);
        if (in_front && !now_in_front) {
            float crossing = bisect(before, s);
            if (crossing >= 0.0)
                return crossing;
        }
        in_front = now_in_front;
        before = s;
    }
    return NOTHING_FOUND;
}

float solve(float far, float near) {
    float arc_px = arc(far, near);
    float nearest = converge(far);
    // On a silhouette the other side is found from one of these.
    for (int i = 1; i < GATHER_SEEDS && arc_px > 1.0; ++i)
        nearest = max(nearest, converge(mix(far, near, float(i) / float(GATHER_SEEDS - 1))));
    if (nearest < 0.0)
        return scan(far, near, arc_px);
    float before = arc_px <= 1.0 ? nearest : last_before_anything(nearest, near);
    return before == nearest ? nearest : scan(far, before, arc(far, before));
}

/// How near and how far is what may be seen through a box of pixels: of the blocks that its four planes do not leave
/// out.
vec2 span_of(ivec2 first, ivec2 last) {
    vec3 corners[4] = vec3[4](ray_of(eye, first), ray_of(eye, ivec2(last.x, first.y)), ray_of(eye, last),
                              ray_of(eye, ivec2(first.x, last.y)));
    vec4 planes[4];
    for (int i = 0; i < 4; ++i) {
        vec3 n = normalize(cross(corners[i], corners[(i + 1) & 3]));
        planes[i] = vec4(n, dot(n, eye.eye.xyz));
    }
    int own = int(gl_LocalInvocationIndex);
    float nearest = 0.0, farthest = LARGEST;
    for (int i = own; i < block_grid.x * block_grid.y; i += INVOCATIONS) {
        SourceBlock block = source_blocks[i];
        bool shows = shows_something(block);
        for (int j = 0; j < 4 && shows; ++j)
            shows = is_before(planes[j], block, block.inverses);
        if (shows) {
            nearest = max(nearest, block.inverses.x);
            farthest = min(farthest, block.inverses.y);
        }
    }
    tile_nearest[own] = nearest;
    tile_farthest[own] = farthest;
    barrier();
    for (int step = INVOCATIONS / 2; step > 0; step /= 2) {
        if (own < step) {
            tile_nearest[own] = max(tile_nearest[own], tile_nearest[own + step]);
            tile_farthest[own] = min(tile_farthest[own], tile_farthest[own + step]);
        }
        barrier();
    }
    return vec2(tile_nearest[0], tile_farthest[0]);
}

void main() {
    int eye_number = int(gl_WorkGroupID.z);
    eye = eyes[eye_number];
    box_radius_m = eye.agreement.x;
    budget = eye.agreement.y;
    tolerance = budget;
    eye_square = dot(eye.eye.xyz, eye.eye.xyz);
    ivec2 middle = source_size / 2;
    vec3 chord = lattice_direction(middle + ivec2(0, 1)) - lattice_direction(middle);
    down_longer = 0.5 * dot(chord, chord);
    ivec2 size = imageSize(eye_inverse_planar).xy, first = ivec2(gl_WorkGroupID.xy) * GATHER_TILE_SIDE;
    ivec2 end = min(first + GATHER_TILE_SIDE, size);
    vec2 span = span_of(first - 1, end);
    for (int i = int(gl_LocalInvocationIndex); i < GATHER_TILE_SIDE * GATHER_TILE_SIDE; i += INVOCATIONS) {
        ivec2 pixel = first + ivec2(i % GATHER_TILE_SIDE, i / GATHER_TILE_SIDE);
        if (any(greaterThanEqual(pixel, end)))
            continue;
        ray = ray_of(eye, pixel);
        ray_square = dot(ray, ray);
        along_eye = dot(ray, eye.eye.xyz);
        // Surfaces go on a little beyond their samples.
        float far = leaves(span.y * (1.0 - BEYOND_SAMPLES)), near = min(leaves(span.x * (1.0 + BEYOND_SAMPLES)), NEAREST_S);
        float found = span.y <= span.x ? solve(far, near) : NOTHING_FOUND;
        imageStore(eye_inverse_planar, ivec3(pixel, eye_number), vec4(found >= 0.0 ? found : UNKNOWN));
    }
}
