// Depth of a source's samples from flat views at its centre, where it is simple: where the four texels around a
// sample's direction show one triangle, or a surface that goes on as it comes within the bound, depth lies between
// theirs. The others go on a list, for sphere_depth.glsl.
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;

#include "sphere_samples.glsl"
#include "pixel_list.glsl"

uniform float box_radius_m;
uniform float error;  // of bounded inverse depth
uniform ivec2 first;  // of the samples that are wanted
uniform ivec2 wanted;

/// Four texels of a row or column in order: whether the step in their middle is that on one of its sides.
bool goes_on(vec4 z, float most) {
    vec3 steps = z.yzw - z.xyz;
    return min(abs(steps.y - steps.x), abs(steps.y - steps.z)) <= most;
}

/// Depth of four texels, and of a texel more at either end of their rows and columns.
struct Around {
    vec4 z;  // row by row
    vec2 left, right, above, below;
};

/// At the corner that four texels share, a gather finds those and no others. Beyond a view nothing is drawn.
Around depth_around(Place place, ivec2 low) {
    vec2 one = 1.0 / vec2(textureSize(view_depth, 0).xy), middle = vec2(low + 1) * one;
    float layer = float(place.layer);
    vec4 left = textureGather(view_depth, vec3(middle - vec2(one.x, 0.0), layer));
    vec4 right = textureGather(view_depth, vec3(middle + vec2(one.x, 0.0), layer));
    vec4 above = textureGather(view_depth, vec3(middle - vec2(0.0, one.y), layer));
    vec4 below = textureGather(view_depth, vec3(middle + vec2(0.0, one.y), layer));
    return Around(vec4(left.z, right.w, left.y, right.x), left.wx, right.zy, above.wz, below.xy);
}

bool is_smooth(Around depth, float scale) {
    vec4 z = depth.z, near_w = box_radius_m * scale * z;
    // By how much w changes with depth's values.
    vec4 slopes = box_radius_m * scale / ((1.0 - near_w) * (1.0 - near_w));
    float most = error / max(max(slopes.x, slopes.y), max(slopes.z, slopes.w));
    return all(greaterThan(z, vec4(0.0))) && all(lessThan(near_w, vec4(1.0))) &&
           goes_on(vec4(depth.left.x, z.xy, depth.right.x), most) &&
           goes_on(vec4(depth.left.y, z.zw, depth.right.y), most) &&
           goes_on(vec4(depth.above.x, z.xz, depth.below.x), most) &&
           goes_on(vec4(depth.above.y, z.yw, depth.below.y), most);
}

void main() {
    ivec2 index = ivec2(gl_GlobalInvocationID);
    if (any(greaterThanEqual(index, wanted)))
        return;
    ivec2 s = first + index;
    s.x -= s.x >= source_size.x ? source_size.x : 0;
    Place place;
    if (!place_of(direction_of(s), place))
        return;
    ivec2 low = texel_before(place);
    vec2 middle = vec2(low + 1) / vec2(textureSize(view_triangle, 0).xy);
    uvec4 shown = textureGather(view_triangle, vec3(middle, place.layer));
    Around depth = depth_around(place, low);
    float scale = inverse_depth_scale * place.forward;
    if (shown == shown.xxxx || is_smooth(depth, scale)) {
        vec2 weight = place.at - 0.5 - vec2(low);
        vec2 columns = mix(depth.z.xy, depth.z.zw, weight.y);
        float inverse = scale * mix(columns.x, columns.y, weight.x);
        imageStore(sphere_depth, s, vec4(shown == uvec4(0u) ? INFINITE : 1.0 / inverse));
    } else {
        append(ivec3(s, 0));
    }
}
