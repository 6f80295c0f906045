// The flat views from a source's centre, what they show, and which of a source's samples they show where.
layout(binding = 0) uniform sampler2DArray view_depth;
layout(binding = 1) uniform usampler2DArray view_triangle;
layout(binding = 0, r32f) uniform writeonly image2D sphere_depth;

#include "source_grid.glsl"

struct FlatView {
    mat4 view_from_source;
    vec4 size;  // columns, rows, focal length in pixels, layer
};
layout(std140, binding = 1) uniform FlatViews {
    FlatView views[VIEWS];
};

uniform float inverse_depth_scale;

/// Where a sample lies in a view.
struct Place {
    ivec2 size;  // of the view
    int layer;
    vec2 at;        // in texels
    float forward;  // of the sample's unit direction along the view's axis
};

/// The first view that shows a direction; false where there is none.
bool place_of(vec3 d, out Place place) {
    bool found = false;
    for (int i = 0; i < VIEWS; ++i) {
        vec3 seen = mat3(views[i].view_from_source) * d;
        vec4 size = views[i].size;
        vec2 at = 0.5 * size.xy + vec2(seen.x, -seen.y) * (size.z / -seen.z);
        bool shown = seen.z < 0.0 && all(greaterThanEqual(at, vec2(0.0))) &&
                     all(lessThanEqual(at, size.xy));
        if (shown && !found)
            place = Place(ivec2(size.xy), int(size.w), at, -seen.z);
        found = found || shown;
    }
    return found;
}

/// The texel before a place, along both axes; the one after it lies in the view too.
ivec2 texel_before(Place place) {
    return clamp(ivec2(floor(place.at - 0.5)), ivec2(0), place.size - 2);
}
