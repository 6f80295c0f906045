/// Of radians a second to the right and down: red to the right, yellow-green up, cyan to the left, violet down; dark
/// where slow.
vec3 motion_colour(vec2 moves) {
    float hue = 6.0 * fract(atan(-moves.y, moves.x) / (2.0 * PI));
    vec3 full = clamp(abs(mod(hue + vec3(0.0, 4.0, 2.0), 6.0) - 3.0) - 1.0, 0.0, 1.0);
    return full * clamp(length(moves) / FULL_MOTION, 0.0, 1.0);
}
