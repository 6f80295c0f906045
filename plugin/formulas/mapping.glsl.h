// Where a direction falls among a picture's samples: conventions.h in single precision. Directions
// are in the picture's camera frame and of any length. Positions are in samples, from the corner of
// the first.

CONSTANT float quarter_turn = 1.57079632679f;
CONSTANT float half_turn = 3.14159265359f;
CONSTANT float whole_turn = 6.28318530718f;
/// By how much rounding may push a position past a picture's edge, in samples.
CONSTANT float edge_rounding_px = 0.02f;
/// What a flat picture does not show falls far outside of it.
CONSTANT float nowhere_px = -1e9f;

/// atan2 within 4e-7 rad, 1/480 of a sample of a 32,768-wide sphere. By an odd minimax polynomial for
/// the arc tangent on [0, 1]. 0 at (0, 0). NaN for NaN.
FORMULA Number fast_atan2(Number y, Number x) {
    Number ax = abs(x);
    Number ay = abs(y);
    Truth is_steep = ay > ax;
    // What is added divides 0 by something, and changes no direction's length.
    Number a = select(is_steep, ax, ay) / (select(is_steep, ay, ax) + 1e-37f);
    Number s = a * a;
    Number p = -0.004055637f;
    p = p * s + 0.021866976f;
    p = p * s - 0.055918365f;
    p = p * s + 0.096426596f;
    p = p * s - 0.139088192f;
    p = p * s + 0.199466056f;
    p = p * s - 0.333298645f;
    p = p * s + 0.999999337f;
    Number angle = p * a;
    angle = select(is_steep, quarter_turn - angle, angle);
    angle = select(x < 0.0f, half_turn - angle, angle);
    return with_sign_of(angle, y);
}

/// A sphere's column. `middle` is the longitude of its middle: columns count the shortest way from it.
FORMULA Number sphere_column(Number x, Number z, float middle, float columns_per_radian, float half_width) {
    Number longitude = fast_atan2(x, -z) - middle;
    longitude = select(longitude > half_turn, longitude - whole_turn, longitude);
    longitude = select(longitude < -half_turn, longitude + whole_turn, longitude);
    return longitude * columns_per_radian + half_width;
}

/// A sphere's row. `top` is the latitude of its upper edge.
FORMULA Number sphere_row(Number x, Number y, Number z, float top, float rows_per_radian) {
    return (top - fast_atan2(y, sqrt(x * x + z * z))) * rows_per_radian;
}

/// A flat picture's column; what lies behind it falls nowhere.
FORMULA Number flat_column(Number x, Number z, float focal_px, float half_width) {
    return select(z < 0.0f, x * (focal_px / -z) + half_width, nowhere_px);
}

FORMULA Number flat_row(Number y, Number z, float focal_px, float half_height) {
    return half_height - y * (focal_px / -z);
}

/// Whether a column lies in a picture so many samples wide, or a row in one so high. False for NaN.
FORMULA Truth is_within(Number position, float size) {
    return both(position >= -edge_rounding_px, position <= size + edge_rounding_px);
}
