#include "toy_renderer.h"

#include <math.h>

static const float floor_y = -1, radius = 0.8f, to_sun[3] = {0.48f, 0.8f, 0.36f};
static const float light = 0.7f, dark = 0.1f, orange[3] = {0.8f, 0.3f, 0.1f};

static float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

float toy_shift(int object, int from_frame, int to_frame) {
    return object == 2 ? 0.4f * (float)(to_frame - from_frame) : 0;
}

toy_hit toy_trace(const float origin[3], const float direction[3], float t_min, int frame) {
    toy_hit hit = {.distance = INFINITY};
    const float centre[3] = {toy_shift(2, 0, frame), 0, -3};
    const float to[3] = {centre[0] - origin[0], centre[1] - origin[1], centre[2] - origin[2]};
    const float b = dot(to, direction), c = dot(to, to) - radius * radius;
    const float t_ball = b - sqrtf(b * b - c); /* NaN where the ball is missed */
    const float t_floor = (floor_y - origin[1]) / direction[1];
    if (t_floor > t_min && t_floor < 50) hit.object = 1, hit.distance = t_floor;
    if (t_ball > t_min && t_ball < hit.distance) hit.object = 2, hit.distance = t_ball;
    if (hit.object == 0) return hit;
    for (int i = 0; i < 3; i++) hit.position[i] = origin[i] + hit.distance * direction[i];
    const int odd = ((int)floorf(hit.position[0]) + (int)floorf(hit.position[2])) % 2 != 0;
    for (int i = 0; i < 3; i++) {
        hit.normal[i] = hit.object == 2 ? (hit.position[i] - centre[i]) / radius : (float)(i == 1);
        hit.albedo[i] = hit.object == 2 ? orange[i] : odd ? dark : light;
    }
    return hit;
}

void toy_shade(const toy_hit* hit, const float direction[3], float rgb[3]) {
    const float from_sun = 2 * fmaxf(dot(hit->normal, to_sun), 0), from_everywhere = 0.3f;
    for (int i = 0; i < 3; i++)
        rgb[i] = hit->object ? hit->albedo[i] * (from_sun + from_everywhere) : 0.4f + 0.2f * direction[1];
}
