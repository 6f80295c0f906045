// The arithmetic of the fill pass `pushpull` (push_pull.h).

/// Layers of a cell's children are split here into far and near: half way between their least and
/// largest w, and not at all where these agree.
FORMULA Number split_between(Number low, Number high, float tolerance) {
    return select(high - low <= tolerance, high, 0.5f * (low + high));
}

/// What a coarser layer counts, `apart` in w from the one that it colours. 0 for what is infinitely far.
FORMULA Number share_of_layer(Number bilinear, Number apart, float tolerance) {
    float squared = tolerance * tolerance;
    return bilinear * squared / (apart * apart + squared);
}
