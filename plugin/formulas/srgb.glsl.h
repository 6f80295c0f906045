// The sRGB transfer curve (IEC 61966-2-1) on values from 0 to 1, per channel.

FORMULA float srgb_to_linear(float v) {
    return v <= 0.04045f ? v / 12.92f : pow((v + 0.055f) / 1.055f, 2.4f);
}

FORMULA float linear_to_srgb(float v) {
    return v <= 0.0031308f ? v * 12.92f : 1.055f * pow(v, 1.0f / 2.4f) - 0.055f;
}
