// The sample that stands for one beyond a picture's edges. Columns of a picture that closes go round.
// Beyond a pole the rows come back on the other side, half the columns further. Where a picture just
// ends, its edge is repeated.

/// A picture's size, and where its samples go on.
struct Wrapping {
    int width;
    int height;
    bool closes;
    bool north_pole;
    bool south_pole;
};

FORMULA bool is_beyond_pole(Wrapping grid, int y) {
    return (y < 0 && grid.north_pole) || (y >= grid.height && grid.south_pole);
}

/// The row on the other side of the pole; others as they are.
FORMULA int row_over_pole(Wrapping grid, int y) {
    return !is_beyond_pole(grid, y) ? y : y < 0 ? -1 - y : 2 * grid.height - 1 - y;
}

/// The column on the other side of the pole, for a sample of row y.
FORMULA int column_over_pole(Wrapping grid, int x, int y) {
    return is_beyond_pole(grid, y) ? x + grid.width / 2 : x;
}

/// A column at most once round brought back. No remainder: dividing whole numbers is slow.
FORMULA int column_round(Wrapping grid, int x) {
    int around = grid.closes ? grid.width : 0;
    x += x < 0 ? around : 0;
    return x - (x >= grid.width ? around : 0);
}

/// For samples up to two beyond the edges.
FORMULA int wrapped_column(Wrapping grid, int x, int y) {
    return min(max(column_round(grid, column_over_pole(grid, x, y)), 0), grid.width - 1);
}

FORMULA int wrapped_row(Wrapping grid, int y) {
    return min(max(row_over_pole(grid, y), 0), grid.height - 1);
}
