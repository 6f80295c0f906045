// The push of push_pull.h: what a place between the coarser level's cells takes from their layers.

layout(binding = 3) uniform sampler2DArray coarser_layers;
uniform ivec3 coarser;

/// Negative where nothing around has a colour. `at` is a cell or pixel of the finer level.
vec3 pushed(ivec3 at, float w) {
    float squared = eyes[at.z].agreement.y * eyes[at.z].agreement.y;
    ivec2 beside = ivec2((at.x & 1) != 0 ? 1 : -1, (at.y & 1) != 0 ? 1 : -1);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        ivec2 step = ivec2(k & 1, k >> 1);
        ivec3 cell = ivec3((at.xy >> 1) + step * beside, at.z);
        // All tiles beside one with gaps are there.
        if (!is_inside(coarser, cell))
            continue;
        // The cell that holds the place lies nearer than the one beside it, along each axis.
        float bilinear = (step.x == 0 ? 0.75 : 0.25) * (step.y == 0 ? 0.75 : 0.25);
        for (int half_of = 0; half_of < 2; ++half_of) {
            vec4 layer = texelFetch(coarser_layers, layer_at(cell, half_of), 0);
            float apart = layer.w - w;
            if (layer.w >= 0.0 && layer.r >= 0.0)
                sum += bilinear * squared / (apart * apart + squared) * vec4(layer.rgb, 1.0);
        }
    }
    return sum.a > 0.0 ? sum.rgb / sum.a : OPEN;
}
