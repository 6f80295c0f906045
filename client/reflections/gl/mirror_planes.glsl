// What a picture's samples show of mirrors and glass (specular.h).

layout(binding = 6) uniform sampler2D source_specular;
layout(binding = 7) uniform sampler2D source_virtual_depth;  // NaN where nobody has told

bool is_specular(ivec2 s) {
    return texelFetch(source_specular, s, 0).x > MIN_SPECULAR;
}

/// What a sample's mirror shows is so far away; NaN where it shows nothing, or nobody has told.
float image_of(ivec2 s) {
    float image_m = texelFetch(source_virtual_depth, s, 0).x;
    return is_specular(s) && image_m > 0.0 ? min(image_m, FAR_DISTANCE_M) : UNKNOWN;
}
