// 1 / planar depth of an eye's pixels, in gaps that of the background.
uniform usampler2DArray eye_origin;
uniform sampler2DArray eye_depth;

layout(location = 0) out float inverse;

#define INVERSE_PLANAR(at) texelFetch(eye_depth, at, 0).x
#include "background.glsl"

void main() {
    ivec3 at = ivec3(gl_FragCoord.xy, 0);
    inverse = texelFetch(eye_origin, at, 0).x == ORIGIN_GAP ? background_inverse(at, textureSize(eye_depth, 0).xy)
                                                            : INVERSE_PLANAR(at);
}
