// The push of push_pull.h: from the top down to the gaps.
#include "push_pull.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/fill/push_kernels.cpp"
#include <hwy/foreach_target.h>

#include "push_pull-inl.h"

#include <bit>
#include <cstdint>
#include <limits>
#include <span>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// The coarser level's layers around places between the same four cells: of columns `right` - 1 and `right`, of the row
/// that holds the places and the row beside it.
class Sampler {
public:
    HWY_INLINE void move_to(const PullPyramid& pyramid, int coarser, int right, int y) {
        right_ = right;
        const int row = y >> 1, beside = row + ((y & 1) != 0 ? 1 : -1);
        row_w_ = take(pyramid.cell(coarser, right - 1, row), pyramid.cell(coarser, right, row), layers_);
        beside_w_ = take(pyramid.cell(coarser, right - 1, beside), pyramid.cell(coarser, right, beside), layers_ + 4);
    }
    /// Of the cells between which place x lies.
    static int right_of(int x) { return (x + 1) >> 1; }
    int right() const { return right_; }

    /// R, G, B at place x for a layer of this w; false where nothing around has a colour.
    HWY_INLINE bool colour(float tolerance, int x, float w, Floats& rgb) const {
        // Along each axis the cell that holds the place lies nearer (3/4) than the one beside it (1/4).
        const float left = x >> 1 == right_ ? 0.25f : 0.75f;
        const Floats bilinear = hn::IfThenElse(hn::FirstN(tag, 2), all(0.75f * left), all(0.75f * (1 - left)));
        const Floats row = formulas::share_of_layer(bilinear, row_w_ - all(w), tolerance);
        const Floats beside = formulas::share_of_layer(bilinear * all(1 / 3.0f), beside_w_ - all(w), tolerance);
        const Floats mean = mixed(row, layers_) + mixed(beside, layers_ + 4);
        const Floats sum = hn::Broadcast<3>(mean);
        rgb = mean / sum;
        return hn::GetLane(sum) > 0;
    }

private:
    /// Four layers, the last number of each being the sum of their shares.
    static HWY_INLINE Floats mixed(Floats share, const Layer* layers) {
        const auto layer = [&](int i) HWY_ATTR { return hn::Load(tag, &layers[i].r); };
        return hn::MulAdd(hn::Broadcast<0>(share), layer(0), hn::Broadcast<1>(share) * layer(1)) +
               hn::MulAdd(hn::Broadcast<2>(share), layer(2), hn::Broadcast<3>(share) * layer(3));
    }

    /// Four layers of two cells: their w, infinite for those without a colour, so that these have no share; and 1 in
    /// its place.
    HWY_INLINE Floats take(const PullPyramid::Cell& left, const PullPyramid::Cell& right, Layer* to) {
        // By address and not by a branch, which nobody could foretell.
        static constexpr Layer none{0, 0, 0, std::numeric_limits<float>::infinity()};
        const auto layer = [&](bool coloured, const Layer* there) HWY_ATTR {
            const Layer* from[] = {&none, there};
            return hn::LoadU(tag, &from[coloured ? 1 : 0]->r);
        };
        const Floats four[] = {layer(left.coloured[0], left.far), layer(left.coloured[1], left.near),
                               layer(right.coloured[0], right.far), layer(right.coloured[1], right.near)};
        for (int i = 0; i < 4; ++i)
            hn::Store(hn::IfThenElse(hn::FirstN(tag, 3), four[i], all(1)), tag, &to[i].r);
        const Floats left_w = hn::InterleaveUpper(tag, four[0], four[1]);  // b, b, w, w
        const Floats right_w = hn::InterleaveUpper(tag, four[2], four[3]);
        return hn::ConcatUpperUpper(tag, right_w, left_w);
    }

    int right_ = -1;
    alignas(16) Layer layers_[8];
    Floats row_w_, beside_w_;
};

/// Colours the open layers of cell i of a level, which is cell x, y of the picture.
template <std::size_t Cells>
HWY_INLINE void push_cell(const PullPyramid& pyramid, int level, int x, int y, PullPyramid::Layers<Cells>& layers,
                          PullPyramid::LayerBits& bits, int i) {
    Sampler sampler;
    sampler.move_to(pyramid, level + 1, Sampler::right_of(x), y);
    for (std::size_t half = 0; half < 2; ++half) {
        if ((bits[half].open() >> i & 1) == 0)
            continue;
        Layer& layer = layers[half][std::size_t(i)];
        Floats rgb;
        if (!sampler.colour(pyramid.depths.tolerance, x, layer.w, rgb))
            continue;
        alignas(16) float numbers[4];
        hn::Store(rgb, tag, numbers);
        layer = {numbers[0], numbers[1], numbers[2], layer.w};
        bits[half].coloured = std::uint16_t(bits[half].coloured | 1u << i);
    }
}

void push_upper_level_here(PullPyramid& pyramid, int level) {
    PullPyramid::Level& upper = pyramid.upper_levels[std::size_t(level - PullPyramid::tile_levels - 1)];
    for (int y = 0; y < upper.rows; ++y)
        for (int x = 0; x < upper.columns; ++x) {
            PullPyramid::OneCell& cell = upper.cells[std::size_t(y) * upper.columns + x];
            if ((cell.bits[0].open() | cell.bits[1].open()) != 0)
                push_cell(pyramid, level, x, y, cell.layers, cell.bits, 0);
        }
}

template <std::size_t Cells>
HWY_INLINE void push_tile(const PullPyramid& pyramid, int level, const Tile& tile, PullPyramid::Layers<Cells>& layers,
                          PullPyramid::LayerBits& bits) {
    const int shift = PullPyramid::tile_levels - level;
    for (unsigned open = bits[0].open() | bits[1].open(); open != 0; open &= open - 1) {
        const int i = std::countr_zero(open);
        push_cell(pyramid, level, (tile.column << shift) + (i & ((1 << shift) - 1)), (tile.row << shift) + (i >> shift),
                  layers, bits, i);
    }
}

void push_tiles_here(PullPyramid& pyramid, int level, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
        const std::size_t at = std::size_t(pyramid.tiles_with_gaps[i]);
        Tile& tile = pyramid.tiles[at];
        if (level == 1)
            push_tile(pyramid, level, tile, pyramid.tile_layers[at].level1, tile.bits1);
        else if (level == 2)
            push_tile(pyramid, level, tile, pyramid.tile_layers[at].level2, tile.bits2);
        else
            push_tile(pyramid, level, tile, tile.level3.layers, tile.level3.bits);
    }
}

HWY_INLINE void ask_for(const PullPyramid& pyramid, const GapSpan& span) {
    const EyePicture& picture = *pyramid.picture;
    hwy::Prefetch(picture.rgba.pixel(span.begin, span.y));
    hwy::Prefetch(picture.origin.pixel(span.begin, span.y));
    if (pyramid.depths.gap_m.data != nullptr)
        hwy::Prefetch(pyramid.depths.gap_m.row(span.y) + span.begin);
    const int beside = span.y / 2 + ((span.y & 1) != 0 ? 1 : -1);
    hwy::Prefetch(pyramid.cell(1, span.begin / 2, span.y / 2).far);
    hwy::Prefetch(pyramid.cell(1, span.begin / 2, beside).far);
}

std::int64_t colour_spans_here(const PullPyramid& pyramid, std::span<const GapSpan> spans) {
    const SurfaceDepths& depths = pyramid.depths;
    EyePicture& picture = *pyramid.picture;
    std::int64_t coloured = 0;
    Sampler sampler;
    constexpr std::size_t ahead = 8;
    for (std::size_t i = 0; i < spans.size(); ++i) {
        if (i + ahead < spans.size())
            ask_for(pyramid, spans[i + ahead]);
        const GapSpan& span = spans[i];
        for (int x = span.begin; x < span.end; ++x) {
            if (x == span.begin || Sampler::right_of(x) != sampler.right())
                sampler.move_to(pyramid, 1, Sampler::right_of(x), span.y);
            Floats rgb;
            if (!sampler.colour(depths.tolerance, x, depths.w_at(depths.gap_m, x, span.y), rgb))
                continue;
            alignas(16) std::int32_t numbers[4];
            hn::Store(hn::ConvertTo(int_tag, rgb + all(0.5f)), int_tag, numbers);
            std::uint8_t* rgba = picture.rgba.pixel(x, span.y);
            for (int c = 0; c < 3; ++c)
                rgba[c] = std::uint8_t(numbers[c]);
            rgba[3] = 255;
            *picture.origin.pixel(x, span.y) = std::uint8_t(PixelOrigin::push_pull);
            ++coloured;
        }
    }
    return coloured;
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace equistream {

HWY_EXPORT(push_upper_level_here);
HWY_EXPORT(push_tiles_here);
HWY_EXPORT(colour_spans_here);

void push_upper_level(PullPyramid& pyramid, int level) {
    HWY_DYNAMIC_DISPATCH(push_upper_level_here)(pyramid, level);
}
void push_tiles(PullPyramid& pyramid, int level, std::size_t first, std::size_t last) {
    HWY_DYNAMIC_DISPATCH(push_tiles_here)(pyramid, level, first, last);
}
std::int64_t colour_spans(const PullPyramid& pyramid, std::span<const GapSpan> spans) {
    return HWY_DYNAMIC_DISPATCH(colour_spans_here)(pyramid, spans);
}

}  // namespace equistream
#endif
