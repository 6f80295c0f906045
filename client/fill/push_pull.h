#pragma once
/// The `pushpull` fill pass: its pyramid, the loops over it and the filling of one picture.
#include "gaps.h"

#include <equistream/depth_agreement.h>

#include <client/warp/view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace equistream {

// The pyramid of the `pushpull` fill pass (PushPull says what it computes) as it lies in memory: 8x8 tiles of
// pixels near gaps with their own three levels, and dense levels above. Plain values and what finds them only; the
// loops are below.

/// w of a pixel, and e.
struct SurfaceDepths {
    ImageView<const float> known_m{};  ///< distances of coloured pixels; empty: all alike
    ImageView<const float> gap_m{};    ///< of gap pixels; empty: all alike
    float box_radius_m = 0;
    float tolerance = 0;

    float w_at(ImageView<const float> depth_m, int x, int y) const {
        if (depth_m.data == nullptr)
            return 0;
        const float depth = depth_m.pixel(x, y)[0];
        return depth > 0 ? formulas::w_of(depth, box_radius_m) : 0;
    }
};

struct PullPyramid {
    static constexpr int tile_levels = 3;
    static constexpr int tile_side = 1 << tile_levels;

    struct Layer {
        float r = 0, g = 0, b = 0, w = 0;
    };
    /// Of some cells, a bit each: which have the layer, and which of these a colour.
    struct Bits {
        std::uint16_t present = 0, coloured = 0;
        unsigned open() const { return present & ~unsigned(coloured); }
    };
    /// Layers far and near, meaningless where not present.
    template <std::size_t Cells>
    using Layers = std::array<std::array<Layer, Cells>, 2>;
    using LayerBits = std::array<Bits, 2>;
    struct OneCell {
        Layers<1> layers;
        LayerBits bits;
    };
    /// What is asked of most tiles, a line of the cache each; the rest of theirs is apart from it.
    struct alignas(64) Tile {
        int column = 0, row = 0;
        LayerBits bits1, bits2;
        OneCell level3;
    };
    struct TileLayers {
        Layers<16> level1;
        Layers<4> level2;
    };
    /// Levels above: dense, level 4 first.
    struct Level {
        int columns = 0, rows = 0;
        std::vector<OneCell> cells{};
    };

    /// A cell's layers wherever they lie; null for a cell that is not there.
    struct Cell {
        const Layer* far = nullptr;
        const Layer* near = nullptr;
        std::array<bool, 2> present{}, coloured{};
    };
    Cell cell(int level, int x, int y) const {
        if (x < 0 || y < 0)
            return {};
        if (level > tile_levels) {
            const Level& upper = upper_levels[std::size_t(level - tile_levels - 1)];
            if (x >= upper.columns || y >= upper.rows)
                return {};
            const OneCell& cell = upper.cells[std::size_t(y) * upper.columns + x];
            return of(cell.layers, cell.bits, 0);
        }
        const int shift = tile_levels - level;
        const int column = x >> shift, row = y >> shift;
        if (column >= tile_columns || row >= tile_rows)
            return {};
        const std::int32_t index = tile_of[std::size_t(row) * tile_columns + column];
        if (index < 0)
            return {};
        const Tile& tile = tiles[std::size_t(index)];
        const int mask = (1 << shift) - 1;
        const int i = ((y & mask) << shift) + (x & mask);
        const TileLayers& layers = tile_layers[std::size_t(index)];
        return level == 1   ? of(layers.level1, tile.bits1, i)
               : level == 2 ? of(layers.level2, tile.bits2, i)
                            : of(tile.level3.layers, tile.level3.bits, i);
    }

    SurfaceDepths depths;
    EyePicture* picture = nullptr;
    int tile_columns = 0, tile_rows = 0;
    std::vector<std::int32_t> tile_of;  ///< -1: none
    std::vector<Tile> tiles;
    std::vector<TileLayers> tile_layers;        ///< of each tile
    std::vector<std::int32_t> tiles_with_gaps;  ///< the others have no open layers
    std::vector<Level> upper_levels;

private:
    template <std::size_t Cells>
    static Cell of(const Layers<Cells>& layers, const LayerBits& all, int i) {
        const auto bit = [i](unsigned bits) { return (bits >> i & 1) != 0; };
        return {&layers[0][std::size_t(i)],
                &layers[1][std::size_t(i)],
                {bit(all[0].present), bit(all[1].present)},
                {bit(all[0].coloured), bit(all[1].coloured)}};
    }
};

// The `pushpull` fill pass's filling of one picture. What it computes, level by level (pixels are level 0; a cell of
// level l covers 2^l x 2^l pixels):
//
// A pixel has one layer, a cell up to two, far and near. A layer has a mean w = B / (r - B) (depth_agreement.h) and is
// *coloured* or *open*: open where all its pixels are gaps. Only pixels in or next to 8x8 tiles that hold a gap count;
// all others are not there.
//   pull  The layers of a cell's four children are split half way between their least and largest w, unless these
//         differ by no more than e; the far half makes the cell's far layer, the other its near one: the mean of their
//         w, and the mean colour of those that are coloured.
//   push  From the top down, an open layer takes the colour of the coarser level's layers around it: bilinear, times
//         1 / (1 + (dw / e)^2), so that those at its own depth count before all others.
// Gap pixels are the open layers of level 0.

class PushPull {
public:
    /// Colours the gaps of the picture; returns how many (all, if anything is coloured at all). Keeps its memory for
    /// the next picture.
    std::int64_t run(const SurfaceDepths& depths, const Gaps& gaps, EyePicture& picture);

private:
    void find_tiles(const Gaps& gaps, int width, int height);
    void size_upper_levels();

    PullPyramid pyramid_;
};

// The loops of the `pushpull` pyramid, for every instruction set that Highway compiles them for; the one that this
// processor has is picked when they run. Different tiles and spans may be worked on by different threads.

/// Levels 1 to 3 of tiles `first` to before `last`.
void pull_tiles(PullPyramid& pyramid, std::size_t first, std::size_t last);
/// A dense level from the one below it, which is finished.
void pull_upper_level(PullPyramid& pyramid, int level);
/// Open layers of a dense level get colours of the level above.
void push_upper_level(PullPyramid& pyramid, int level);
/// The same of one level of the tiles that tiles_with_gaps has from `first` to before `last`.
void push_tiles(PullPyramid& pyramid, int level, std::size_t first, std::size_t last);
/// Gap pixels, from level 1; how many got a colour.
std::int64_t colour_spans(const PullPyramid& pyramid, std::span<const GapSpan> spans);

}  // namespace equistream
