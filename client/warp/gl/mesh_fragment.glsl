// 1 / planar depth of what an eye sees of a mesh.
in float point_inverse;
layout(location = 0) out float inverse_planar;

void main() {
    inverse_planar = max(point_inverse * gl_FragCoord.w, 0.0);
}
