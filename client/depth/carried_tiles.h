#pragma once
/// Which tiles of a sphere's picture see one plane, and which of those still do from elsewhere: they are filled without
/// a look at their pixels. Internal to depth reuse.
#include "sphere_angles.h"
#include "sphere_warp.h"

#include <equistream/camera.h>

#include <cstdint>
#include <vector>

namespace equistream {

class CarriedTiles {
public:
    /// Both are borrowed.
    CarriedTiles(const EquirectCamera& camera, const SphereAngles& angles);

    int columns() const { return columns_; }
    int rows() const { return rows_; }
    /// The plane that all of a tile sees, or `mixed`; tiles of a row lie side by side.
    std::int32_t& seen(int column, int row) { return seen_[std::size_t(row) * std::size_t(columns_) + column]; }
    std::int32_t seen(int column, int row) const { return seen_[std::size_t(row) * std::size_t(columns_) + column]; }

    /// The plane of a tile, if all that its pixels saw before, wherever that was, is of that plane; else `mixed`.
    std::int32_t still_seen(const SphereWarp& warp, int tile_column, int tile_row) const;
    /// Where all rows next to a pole, and those that can come there, see one plane: it; else `mixed`.
    std::int32_t cap(const SphereWarp& warp, bool top) const;

private:
    float met(const SphereWarp& warp, std::int32_t plane, int x, int y) const;

    const EquirectCamera& camera_;
    const SphereAngles& angles_;
    int columns_, rows_;
    std::vector<std::int32_t> seen_;
};

}  // namespace equistream
