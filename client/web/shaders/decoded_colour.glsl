// A decoder's planes as RGB.
#include "yuv_colour.glsl"

layout(location = 0) out vec4 colour;

void main() {
    colour = vec4(rgb_of(ivec2(gl_FragCoord.xy)), 1.0);
}
