// Mirrors and glass (specular.h): pixels that an engine took from a mirror's sample are kept, looked up by the image in
// it, or made gaps. The formulas of mirror_kernels.cpp and specular.h.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

layout(binding = 0) uniform sampler2D source_colour;
layout(binding = 1) uniform sampler2D source_depth;
layout(binding = 3) uniform usampler2DArray eye_origin;
layout(binding = 0, rgba8) uniform writeonly image2DArray eye_colour;
layout(binding = 1, r8ui) uniform writeonly uimage2DArray reworked_origin;  // the same as eye_origin

#include "source_grid.glsl"
#include "eye_rays.glsl"
#include "eye_surface.glsl"
#include "depth_clearance.glsl"
#include "mirror_planes.glsl"
#include "in_levels.glsl"

uniform int looks_for_images;  // 0: what is not known to be within the budget is a gap

ivec2 nearest_sample(vec2 position) {
    return clamp(ivec2(floor(position)), ivec2(0), source_size - 1);
}

float image_towards(vec3 d) {
    vec2 position = position_of(d);
    return is_covered(position) ? image_of(nearest_sample(position)) : UNKNOWN;
}

bool is_displaced_by_little(vec3 eye, vec3 ray, vec3 towards, float image_m) {
    vec3 from_eye = towards * (image_m / length(towards)) - eye;
    vec3 beside = from_eye - ray * dot(from_eye, ray);
    return dot(beside, beside) <= MAX_IMAGE_DISPLACEMENT * MAX_IMAGE_DISPLACEMENT * dot(from_eye, from_eye);
}

/// From a distance along a ray to the image that the source has in that direction, to the ray's point nearest to it, and
/// so on, until the image lies on the ray.
bool follow(vec3 eye, vec3 ray, float distance_m, out vec2 at) {
    at = vec2(0.0);
    for (int turn = 0; turn < MAX_IMAGE_TURNS; ++turn) {
        vec3 point = eye + ray * distance_m;
        vec3 from_eye = point * (image_towards(point) / length(point)) - eye;
        distance_m = dot(from_eye, ray);
        if (isnan(distance_m) || distance_m <= 0.0)
            return false;
        vec3 beside = from_eye - ray * distance_m;
        float off = tolerance * distance_m;
        if (dot(beside, beside) <= off * off) {
            at = position_of(eye + ray * distance_m);
            return is_covered(at) && !isnan(image_of(nearest_sample(at)));
        }
    }
    return false;
}

/// The first image on a ray beyond the surface that it meets.
bool first_image(vec3 eye, vec3 ray, float surface_m, out vec2 at) {
    float nearest_inverse = 1.0 / surface_m;
    float apart = ceil(distance(position_of(ray + eye * nearest_inverse), position_of(ray)));
    int steps = int(clamp(apart, 1.0, float(MAX_IMAGE_STEPS)));
    float step_inverse = nearest_inverse / float(steps);
    bool before = true;
    at = vec2(0.0);
    for (int k = 0; k <= steps; ++k) {
        float inverse = max(nearest_inverse - float(k) * step_inverse, 0.0);
        vec3 towards = ray + eye * inverse;
        float image_m = image_towards(towards);
        // A step more: the image may lie between this sample and the next.
        bool behind = inverse / length(towards) <= 1.0 / image_m + step_inverse;
        if (behind && (before || k == steps) && follow(eye, ray, image_m, at))
            return true;
        before = !behind;
    }
    return false;
}

/// 1 / distance of a sample's image, NaN where there is none or nobody has told.
float inverse_image(ivec2 s) {
    return s.y < 0 || s.y >= source_size.y ? UNKNOWN : 1.0 / image_of(wrapped(s));
}

/// Whether a sample and the one a step further show one image.
bool show_one(ivec2 s, ivec2 step) {
    return are_joined(inverse_image(s - step), inverse_image(s), inverse_image(s + step), inverse_image(s + 2 * step));
}

/// What is seen at a position found: of the four samples around, those that show the nearest one's image.
vec3 colour_at(vec2 position) {
    const ivec2 RIGHT = ivec2(1, 0), DOWN = ivec2(0, 1);
    ivec2 corner = ivec2(floor(position - 0.5));
    vec2 s = position - 0.5 - vec2(corner);
    ivec2 near = ivec2(greaterThanEqual(s, vec2(0.5)));
    bool beside = show_one(corner + near.y * DOWN, RIGHT), above = show_one(corner + near.x * RIGHT, DOWN);
    bool across = (beside && show_one(corner + (1 - near.x) * RIGHT, DOWN)) ||
                  (above && show_one(corner + (1 - near.y) * DOWN, RIGHT));
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        ivec2 step = ivec2(k & 1, k >> 1);
        bvec2 far = notEqual(step, near);
        if (!(far.x && far.y ? across : far.x ? beside : far.y ? above : true))
            continue;
        float weight = (step.x == 0 ? 1.0 - s.x : s.x) * (step.y == 0 ? 1.0 - s.y : s.y);
        sum += weight * vec4(texelFetch(source_colour, wrapped(corner + step), 0).rgb, 1.0);
    }
    return sum.rgb / sum.a;
}

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at.xy, imageSize(eye_colour).xy)) || texelFetch(eye_origin, at, 0).x != ORIGIN_SOURCE)
        return;
    EyeRays eye = eyes[at.z];
    box_radius_m = eye.agreement.x;
    tolerance = eye.agreement.y;
    float z = inverse_planar(at);
    if (eye.view.w == 0.0 || isnan(z) || z < 0.0)
        return;
    vec3 along = ray_of(eye, at.xy), ray = normalize(along);
    float surface_m = z > 0.0 ? min(length(along) / z, FAR_DISTANCE_M) : FAR_DISTANCE_M;
    vec3 towards = ray + eye.eye.xyz / surface_m;
    vec2 position = position_of(towards);
    ivec2 s = nearest_sample(position);
    if (!is_covered(position) || !is_specular(s))
        return;
    float image_m = image_of(s), w_image = isnan(image_m) ? 0.0 : w_of(image_m);
    bool kept = abs(w_image - w_of(texelFetch(source_depth, s, 0).x)) <= tolerance;
    if (kept && (looks_for_images != 0 || !isnan(image_m)))
        return;
    vec2 found;
    if (looks_for_images != 0 && !isnan(image_m)) {
        if (first_image(eye.eye.xyz, ray, surface_m, found)) {
            imageStore(eye_colour, at, vec4(in_levels(colour_at(found)), 1.0));
            return;
        }
        if (is_displaced_by_little(eye.eye.xyz, ray, towards, image_m))
            return;
    }
    imageStore(eye_colour, at, vec4(0.0));
    imageStore(reworked_origin, at, uvec4(ORIGIN_GAP));
}
