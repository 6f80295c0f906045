// What the colours of motion say: a disc and its rim.
#include "motion_colour.glsl"

uniform vec2 middle;  // in the window's pixels

out vec4 colour;

void main() {
    vec2 up = (gl_FragCoord.xy - middle) / LEGEND_RADIUS;
    float away = length(up);
    if (away >= LEGEND_RIM)
        discard;
    colour = vec4(away > 1.0 ? vec3(0.9) : motion_colour(FULL_MOTION * vec2(up.x, -up.y)), 1.0);
}
