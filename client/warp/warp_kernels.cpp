#include "resample.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/warp/warp_kernels.cpp"
#include <hwy/foreach_target.h>

#include "warp_colour-inl.h"
#include "warp_fit-inl.h"
#include "warp_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// Leaves only pixels that nobody has coloured yet; false if there are none.
bool keep_open(const WarpJob& job, Tile& tile) {
    bool any = false;
    for (int row = 0; row < tile.rows; ++row) {
        const std::uint8_t* origin = job.origin.pixel(tile.x, tile.y + row);
        for (int i = 0; i < tile.columns; ++i) {
            const bool open = origin[i] == std::uint8_t(PixelOrigin::gap);
            any = any || open;
            if (!open)
                tile.keep[row * tile_width + i] = 0;
        }
    }
    return any;
}

bool any_open(const WarpJob& job, const Tile& tile) {
    for (int row = 0; row < tile.rows; ++row) {
        const std::uint8_t* origin = job.origin.pixel(tile.x, tile.y + row);
        if (std::find(origin, origin + tile.columns, std::uint8_t(PixelOrigin::gap)) != origin + tile.columns)
            return true;
    }
    return false;
}

/// Calls `map(tile)` for the tiles that have something to colour, and colours them.
template <typename Map>
std::int64_t over_tiles(const WarpJob& job, int row, const Map& map) {
    Tile tile;
    std::int64_t count = 0;
    tile.y = row * tile_height;
    tile.rows = std::min(tile_height, job.eye.camera.height - tile.y);
    for (int column = 0; column * tile_width < job.eye.camera.width; ++column) {
        tile.x = column * tile_width;
        tile.columns = std::min(tile_width, job.eye.camera.width - tile.x);
        if (job.only_gaps && !any_open(job, tile))
            continue;
        map(tile);
        if (job.only_gaps) {
            if (tile.regular)
                std::fill_n(tile.keep, tile_pixels, 15);
            tile.regular = false;
            keep_open(job, tile);
        }
        count += colour(job, tile);
    }
    return count;
}

std::int64_t warp_tiles_here(const WarpJob& job, int first, int last) {
    std::int64_t count = 0;
    if (job.surface) {
        InversePlanarRows rows(job);
        for (int row = first; row < last; ++row) {
            rows.prepare(row * tile_height);
            count += over_tiles(job, row, [&](Tile& tile) HWY_ATTR { map_surface(job, rows, tile); });
        }
        return count;
    }
    DirectionFits fits(job);
    for (int row = first; row < last; ++row)
        count += over_tiles(job, row, [&](Tile& tile) HWY_ATTR {
            if (!fits.map(tile))
                map_exactly(job, tile);
        });
    return count;
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace equistream {

HWY_EXPORT(warp_tiles_here);

std::int64_t warp_tiles(const WarpJob& job, int first, int last) {
    return HWY_DYNAMIC_DISPATCH(warp_tiles_here)(job, first, last);
}

}  // namespace equistream
#endif
