// One triangle that covers everything, an instance for each layer.
#extension GL_ARB_shader_viewport_layer_array : require

flat out int eye_number;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
    gl_Layer = gl_InstanceID;
    eye_number = gl_InstanceID;
}
