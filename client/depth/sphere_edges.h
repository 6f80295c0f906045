#pragma once
/// Where one surface of a sphere's picture ends before another: between which four pixels, and how the planes of the
/// others go together. By whole registers, as in sphere_warp.h; internal to depth reuse.
#include "sphere_warp.h"

#include <vector>

namespace equistream {

/// The planes of a row's pixels as find_edges needs them.
struct PlaneRow {
    explicit PlaneRow(int width);
    std::vector<float> x, y, z, scale;  ///< normal; 1 / distance from here
};

/// The planes that row `y` sees, spare columns of `here.seen` filled.
void spread_planes(const SphereWarp& here, int y, PlaneRow& planes);

/// A row and the one below it.
struct RowPair {
    const SphereRow &row, &below;
    const PlaneRow &planes, &planes_below;
};

/// Sets `cells` of a row; sets to `mixed` what is not, with the row below and the column to the right, all of one
/// plane, in `tiles`; adds the columns of cells where one surface ends before another to `edges`.
void find_edges(const SphereWarp& here, const RowPair& rows, std::uint8_t* cells, std::int32_t* tiles,
                std::vector<int>& edges);

}  // namespace equistream
