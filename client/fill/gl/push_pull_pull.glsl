// The pull of push_pull.h, from up to eight layers of four children.
#include "push_pull.glsl.h"

struct Halves {
    vec4 far, near;
};

Halves pulled(vec4 children[8], float tolerance) {
    float low = INFINITE, high = -INFINITE;
    for (int i = 0; i < 8; ++i)
        if (children[i].w >= 0.0) {
            low = min(low, children[i].w);
            high = max(high, children[i].w);
        }
    float split = split_between(low, high, tolerance);
    vec4 sums[2] = vec4[2](vec4(0.0), vec4(0.0));
    vec2 counts[2] = vec2[2](vec2(0.0), vec2(0.0));  // present, coloured
    for (int i = 0; i < 8; ++i) {
        vec4 child = children[i];
        float here = child.w >= 0.0 ? 1.0 : 0.0, shown = child.r >= 0.0 ? here : 0.0;
        vec4 part = vec4(shown * child.rgb, here * child.w);
        vec2 one = vec2(here, shown);
        bool is_far = child.w <= split;
        sums[0] += is_far ? part : vec4(0.0);
        counts[0] += is_far ? one : vec2(0.0);
        sums[1] += is_far ? vec4(0.0) : part;
        counts[1] += is_far ? vec2(0.0) : one;
    }
    vec4 means[2];
    for (int half_of = 0; half_of < 2; ++half_of) {
        vec3 colour = counts[half_of].y > 0.0 ? sums[half_of].rgb / counts[half_of].y : vec3(-1.0);
        means[half_of] = counts[half_of].x > 0.0 ? vec4(colour, sums[half_of].w / counts[half_of].x) : vec4(-1.0);
    }
    return Halves(means[0], means[1]);
}
