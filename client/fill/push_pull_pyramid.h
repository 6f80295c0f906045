#pragma once
/// The pyramid of the `pushpull` fill pass (push_pull.h says what it computes) as it lies in memory: 8x8 tiles of
/// pixels near gaps with their own three levels, and dense levels above. Plain values and what finds them only; the
/// loops are in push_pull_kernels.h.
#include <client/warp/view.h>
#include <equistream/depth_agreement.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace equistream {

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
        return depth > 0 ? box_radius_m / DepthAgreement{box_radius_m, tolerance}.clearance(depth) : 0;
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

}  // namespace equistream
