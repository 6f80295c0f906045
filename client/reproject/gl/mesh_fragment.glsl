// 1 / planar depth of what an eye sees of a mesh's front.
in float point_inverse;
flat in int is_either_way;
layout(location = 0) out float inverse_planar;

void main() {
    if (!gl_FrontFacing && is_either_way == 0)
        discard;
    inverse_planar = max(point_inverse * gl_FragCoord.w, 0.0);
}
