// What an eye sees of a source, and 1 / planar depth of what it sees; NaN in gaps.
layout(location = 0) out vec4 colour;
layout(location = 1) out uint origin;
layout(location = 2) out float inverse;

#define EYE_SIZE textureSize(eye_depth, 0).xy
#include "surface_colour.glsl"

void main() {
    ivec3 at = ivec3(gl_FragCoord.xy, 0);
    colour = seen_colour(at);
    bool seen = colour.a > 0.0;
    origin = seen ? ORIGIN_SOURCE : ORIGIN_GAP;
    inverse = seen && BY_SURFACE ? inverse_planar(at) : UNKNOWN;
}
