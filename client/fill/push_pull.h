#pragma once
/// The pyramid of the `pushpull` rung. What it computes, level by level (pixels are level 0; a cell of level l covers
/// 2^l x 2^l pixels):
///
/// A pixel has one layer, a cell up to two, far and near. A layer has a mean w = B / (r - B) (depth_agreement.h) and is
/// *coloured* or *open*: open where all its pixels are gaps. Only pixels in or next to 8x8 tiles that hold a gap count;
/// all others are not there.
///   pull  The layers of a cell's four children are split half way between their least and largest w, unless these
///         differ by no more than e; the far half makes the cell's far layer, the other its near one: the mean of their
///         w, and the mean colour of those that are coloured.
///   push  From the top down, an open layer takes the colour of the coarser level's layers around it: bilinear, times
///         1 / (1 + (dw / e)^2), so that those at its own depth count before all others.
/// Gap pixels are the open layers of level 0.
#include <equistream_client/gaps.h>
#include <equistream_client/view.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace equistream {

/// w of a pixel, and e.
struct SurfaceDepths {
    ImageView<const float> known_m{};  ///< distances of coloured pixels; empty: all alike
    ImageView<const float> gap_m{};    ///< of gap pixels; empty: all alike
    float box_radius_m = 0;
    float tolerance = 0;
};

class PushPull {
public:
    /// Colours the gaps of the picture; returns how many (all, if anything is coloured at all). Keeps its memory for
    /// the next picture.
    std::int64_t run(const SurfaceDepths& depths, const Gaps& gaps, EyePicture& picture);

    static constexpr int tile_levels = 3;
    static constexpr int tile_side = 1 << tile_levels;

private:
    struct Layer {
        float r = 0, g = 0, b = 0, w = 0;
    };
    enum class State : std::uint8_t { absent, open, coloured };
    struct Cell {
        std::array<Layer, 2> layer{};  ///< far, near
        std::array<State, 2> state{State::absent, State::absent};
    };
    /// Levels 1 to 3 of an 8x8 square of pixels.
    struct Tile {
        int column = 0, row = 0;
        std::array<Cell, 16 + 4 + 1> cells{};
    };
    /// Levels above: dense, level 4 first.
    struct Level {
        int columns = 0, rows = 0;
        std::vector<Cell> cells{};
    };
    class Gathering;
    class Sampler;

    void find_tiles(const Gaps& gaps, int width, int height);
    void pull_tile(Tile& tile) const;
    void pull_pixels(Tile& tile) const;
    void pull_upper_levels();
    void push_upper_levels();
    void push_tiles(int level);
    void push_cell(int level, int x, int y, Cell& cell) const;
    std::int64_t colour_gaps(const Gaps& gaps);

    const Cell* cell(int level, int x, int y) const;
    Cell* cell(int level, int x, int y) { return const_cast<Cell*>(std::as_const(*this).cell(level, x, y)); }
    float w_at(ImageView<const float> depth_m, int x, int y) const;

    SurfaceDepths depths_;
    EyePicture* picture_ = nullptr;
    int tile_columns_ = 0, tile_rows_ = 0;
    std::vector<std::int32_t> tile_of_;  ///< -1: none
    std::vector<Tile> tiles_;
    std::vector<Level> upper_;
};

}  // namespace equistream
