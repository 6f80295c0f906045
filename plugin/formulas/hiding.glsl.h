// Where a smooth surface of the source hides a point (resample.h). Scalars only.

/// What second differences of a smooth surface may be, in tolerances.
CONSTANT float max_bend = 8.0f;
/// How far behind a surface a point is hidden, in tolerances. Nearer to it the surface shows what lies within
/// half a pixel of the point, which is better than what a fill pass fills in.
CONSTANT float min_behind = 2.0f;

/// Whether a smooth surface through sixteen samples runs before a point. `k` has 1 / clearance of each, row by
/// row; `s` and `t` lie between the inner columns and rows. False where a sample is NaN.
FORMULA bool surface_hides(const float k[16], float s, float t, float point, float box_radius_m, float tolerance) {
    float upper = k[5] + s * (k[6] - k[5]);
    float lower = k[9] + s * (k[10] - k[9]);
    float behind = box_radius_m * (upper + t * (lower - upper) - point);
    if (!(behind > min_behind * tolerance))
        return false;
    float most = max_bend * tolerance;
    bool is_smooth = box_radius_m * abs((k[5] - k[6]) - (k[9] - k[10])) <= most;
    float across = 0.0f;
    float down = 0.0f;
    for (int line = 0; line < 4; ++line) {
        float along_row = 0.0f;
        float along_column = 0.0f;
        for (int i = 0; i < 2; ++i) {
            float of_row = abs(k[4 * line + i] - 2.0f * k[4 * line + i + 1] + k[4 * line + i + 2]);
            float of_column = abs(k[line + 4 * i] - 2.0f * k[line + 4 * i + 4] + k[line + 4 * i + 8]);
            is_smooth = is_smooth && box_radius_m * of_row <= most && box_radius_m * of_column <= most;
            along_row += of_row;
            along_column += of_column;
        }
        bool is_inner = line == 1 || line == 2;
        across = is_inner ? max(across, along_row) : across;
        down = is_inner ? max(down, along_column) : down;
    }
    float off = across * s * (1.0f - s) + down * t * (1.0f - t);
    return is_smooth && behind > min_behind * tolerance + box_radius_m * off;
}
