#pragma once
/// The inner loops of looking up (resample.h), by tiles of pixels, for every instruction set that Highway compiles them
/// for; the one that this processor has is picked when they run. Plain values and pointers only: what is here is
/// compiled once, the loops many times.
#include "eye_rays.h"
#include "view.h"

#include <equistream/depth_agreement.h>
#include <plugin/formulas/scalars.h>

#include <algorithm>
#include <cstdint>

namespace equistream {

inline constexpr int tile_width = 16, tile_height = 8;
inline constexpr int tile_pixels = tile_width * tile_height;

/// Positions in the source are in 1/128 of a sample; weights of samples add up to that.
inline constexpr int position_bits = 7;
inline constexpr int position_one = 1 << position_bits;

/// Below this share of the four samples' weight what is left lies too far to one side of the point to stand for it.
inline constexpr float min_weight = 0.1f;

/// Where directions fall among a source's samples, and what lies beyond its edges.
struct SourceGrid : formulas::Wrapping {
    SourceGrid() : formulas::Wrapping{} {}

    bool sphere = true;
    float half_width = 0, half_height = 0;
    float middle = 0, top = 0;                          ///< sphere: longitude and latitude, radians
    float columns_per_radian = 0, rows_per_radian = 0;  ///< sphere
    float focal_px = 1;                                 ///< perspective
};

SourceGrid source_grid(const Camera& camera);

struct Sample {
    int x = 0, y = 0;
};

/// The sample that stands for one up to two beyond the edges.
inline Sample wrapped(const formulas::Wrapping& grid, int x, int y) {
    return {formulas::wrapped_column(grid, x, y), formulas::wrapped_row(grid, y)};
}

/// One eye to be coloured from one source.
struct WarpJob {
    SourceGrid grid;
    const SourceView& source;
    const EyeView& eye;
    EyeRays rays;
    bool surface = false;      ///< by the point that the eye sees; else by direction alone
    bool only_seen = true;     ///< for `surface`: only where the source saw that point
    DepthAgreement agreement;  ///< for `surface`
    float interpolation = 0;   ///< by how much interpolated positions may be off, samples
    float radians_per_sample = 1;
    PixelOrigin mark = PixelOrigin::source;
    bool only_gaps = false;
    ImageView<std::uint8_t> rgba, origin;
};

/// Rows of tiles from `first` to before `last`; returns how many pixels were coloured. Any number of threads, each its
/// own rows.
std::int64_t warp_tiles(const WarpJob& job, int first, int last);

}  // namespace equistream
