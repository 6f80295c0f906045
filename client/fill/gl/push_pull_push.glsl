// The push of push_pull.h: what a place between the coarser level's cells takes from their layers.
#include "push_pull.glsl.h"

layout(binding = 3) uniform sampler2DArray coarser_layers;
uniform ivec3 coarser;

/// A cell's far layer, or, for 1, its near one; NO_LAYER where it has no colour. All tiles beside one with gaps are
/// there.
vec4 coarser_layer(ivec3 cell, int half_of) {
    ivec3 inside = ivec3(clamp(cell.xy, ivec2(0), coarser.xy - 1), cell.z);
    vec4 layer = texelFetch(coarser_layers, layer_at(inside, half_of), 0);
    return inside == cell && layer.w >= 0.0 && layer.r >= 0.0 ? layer : NO_LAYER;
}

/// Negative where nothing around has a colour. Layers are the far and near ones of the cell that holds the place, then
/// of those beside it along x, along y and along both.
vec3 pushed(vec4 layers[8], float w, float tolerance) {
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 8; ++k) {
        // The cell that holds the place lies nearer than the one beside it, along each axis.
        float bilinear = ((k & 2) == 0 ? 0.75 : 0.25) * ((k & 4) == 0 ? 0.75 : 0.25);
        float weight = layers[k].r >= 0.0 ? share_of_layer(bilinear, layers[k].w - w, tolerance) : 0.0;
        sum += weight * vec4(layers[k].rgb, 1.0);
    }
    return sum.a > 0.0 ? sum.rgb / sum.a : OPEN;
}
