// One triangle that covers everything, an instance for each layer, and what all pixels of the layer have alike.
#extension GL_ARB_shader_viewport_layer_array : require

#include "source_grid.glsl"
#include "eye_rays.glsl"

uniform float inverse_depth_scale;  // (see eye_surface.glsl)
uniform ivec2 eye_size;

out GridConstants {
    GRID_MEMBERS(flat)
} grid;
out EyeConstants {
    flat EyeRays eye;
    flat int eye_number;
    flat ivec2 eye_size;
    flat float inverse_depth_scale;
} constants;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
    gl_Layer = gl_InstanceID;
    constants.eye = eyes[gl_InstanceID];
    constants.eye_number = gl_InstanceID;
    constants.eye_size = eye_size;
    constants.inverse_depth_scale = inverse_depth_scale;
    grid.source_size = source_size;
    grid.source_is_sphere = source_is_sphere;
    grid.source_closes = source_closes;
    grid.source_north_pole = source_north_pole;
    grid.source_south_pole = source_south_pole;
    grid.source_focal_px = source_focal_px;
    grid.source_middle = source_middle;
    grid.source_top = source_top;
    grid.columns_per_radian = columns_per_radian;
    grid.rows_per_radian = rows_per_radian;
}
