#include "push_pull_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "../fill/push_pull_kernels.cpp"
// The scalar loops too, whatever the processor has; as in warp_kernels.cpp, nothing here takes high halves of products.
#define HWY_COMPILE_ALL_ATTAINABLE
#define HWY_BROKEN_EMU128 0
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A row of a tile's level 1: four cells, or four numbers of one layer.
using Tag = hn::FixedTag<float, 4>;
using Floats = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;
using IntTag = hn::RebindToSigned<Tag>;
constexpr Tag tag;
constexpr IntTag int_tag;
constexpr int lanes = 4;

using Layer = PullPyramid::Layer;
using Tile = PullPyramid::Tile;

HWY_INLINE Floats all(float value) {
    return hn::Set(tag, value);
}
HWY_INLINE Mask never() {
    return all(0) > all(1);
}
HWY_INLINE Mask mask_of(bool set) {
    return all(set ? 1.0f : 0.0f) > all(0);
}

/// One layer of four cells.
struct Layers {
    Floats r, g, b, w;
    Mask present, coloured;  ///< coloured: only where present
};

/// The pull of push_pull.h: far and near.
template <std::size_t Children>
HWY_INLINE std::array<Layers, 2> pulled(const std::array<Layers, Children>& children, float tolerance) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Floats low = all(infinity), high = all(-infinity);
    for (const Layers& child : children) {
        low = hn::Min(low, hn::IfThenElse(child.present, child.w, all(infinity)));
        high = hn::Max(high, hn::IfThenElse(child.present, child.w, all(-infinity)));
    }
    const Mask alike = high - low <= all(tolerance);
    const Floats split = hn::IfThenElse(alike, high, all(0.5f) * (low + high));
    std::array<Layers, 2> halves;
    for (int half = 0; half < 2; ++half) {
        Layers& sum = halves[std::size_t(half)];
        sum = {all(0), all(0), all(0), all(0), never(), never()};
        if (half == 1 && hn::AllTrue(tag, alike))
            break;
        Floats present = all(0), coloured = all(0);
        for (const Layers& child : children) {
            const Mask here = hn::And(child.present, half == 0 ? child.w <= split : child.w > split);
            const Mask shown = hn::And(here, child.coloured);
            present = present + hn::IfThenElseZero(here, all(1));
            coloured = coloured + hn::IfThenElseZero(shown, all(1));
            sum.w = sum.w + hn::IfThenElseZero(here, child.w);
            sum.r = sum.r + hn::IfThenElseZero(shown, child.r);
            sum.g = sum.g + hn::IfThenElseZero(shown, child.g);
            sum.b = sum.b + hn::IfThenElseZero(shown, child.b);
        }
        sum.present = present > all(0);
        sum.coloured = coloured > all(0);
        const Floats scale = all(1) / hn::Max(coloured, all(1));
        sum.w = sum.w / hn::Max(present, all(1));
        sum.r = sum.r * scale;
        sum.g = sum.g * scale;
        sum.b = sum.b * scale;
    }
    return halves;
}

HWY_INLINE unsigned bits_of(Mask mask) {
    std::uint8_t bits[8];
    hn::StoreMaskBits(tag, mask, bits);
    return bits[0];
}

/// Four cells of a level from the `first` on.
template <std::size_t Cells>
HWY_INLINE void store(const std::array<Layers, 2>& halves, PullPyramid::Square<Cells>& square, int first) {
    for (std::size_t half = 0; half < 2; ++half) {
        const unsigned present = bits_of(halves[half].present);
        if (first == 0)
            square.bits[half] = {};
        if (present == 0)
            continue;
        square.bits[half].present = std::uint16_t(square.bits[half].present | present << first);
        square.bits[half].coloured =
            std::uint16_t(square.bits[half].coloured | bits_of(halves[half].coloured) << first);
        hn::StoreInterleaved4(halves[half].r, halves[half].g, halves[half].b, halves[half].w, tag,
                              &square.layer[half][std::size_t(first)].r);
    }
}

/// Of cells that are four times the same.
HWY_INLINE void store_one(const std::array<Layers, 2>& halves, PullPyramid::Square<1>& square) {
    PullPyramid::Square<4> four;
    store(halves, four, 0);
    for (std::size_t half = 0; half < 2; ++half) {
        square.layer[half][0] = four.layer[half][0];
        square.bits[half] = {std::uint16_t(four.bits[half].present & 1), std::uint16_t(four.bits[half].coloured & 1)};
    }
}

/// Pixels of a tile: colours, w, and what is known of them.
struct Pixels {
    static constexpr int absent = 0, open = 1, coloured = 2;
    alignas(16) std::uint32_t rgba[PullPyramid::tile_side][PullPyramid::tile_side];
    alignas(16) float w[PullPyramid::tile_side][PullPyramid::tile_side];
    alignas(16) std::int32_t state[PullPyramid::tile_side][PullPyramid::tile_side];
};

HWY_INLINE Floats w_from(const SurfaceDepths& depths, ImageView<const float> depth_m, int x, int y) {
    if (depth_m.data == nullptr)
        return all(0);
    const Floats depth = hn::LoadU(tag, depth_m.row(y) + x);
    const Floats r = hn::Min(all(far_distance_m), depth);
    const Floats reach = hn::Max(r * all(1e-3f), r - all(depths.box_radius_m));
    return hn::IfThenElseZero(depth > all(0), all(depths.box_radius_m) / reach);
}

HWY_INLINE void load_pixels(const PullPyramid& pyramid, const Tile& tile, Pixels& pixels) {
    constexpr int side = PullPyramid::tile_side;
    const SurfaceDepths& depths = pyramid.depths;
    const EyePicture& picture = *pyramid.picture;
    const int left = tile.column * side, top = tile.row * side;
    const int columns = std::min(side, picture.origin.width() - left);
    const int rows = std::min(side, picture.origin.height() - top);
    const bool one_depth = depths.known_m.data == depths.gap_m.data;
    for (int y = 0; y < side; ++y) {
        if (y < rows && columns == side) {
            std::copy_n(picture.rgba.pixel(left, top + y), 4 * side, reinterpret_cast<std::uint8_t*>(pixels.rgba[y]));
            const std::uint8_t* origin = picture.origin.pixel(left, top + y);
            for (int x = 0; x < side; x += lanes) {
                const auto mark = hn::PromoteTo(int_tag, hn::LoadU(hn::Rebind<std::uint8_t, Tag>(), origin + x));
                const auto gap = mark == hn::Set(int_tag, int(PixelOrigin::gap));
                const Floats known = w_from(depths, depths.known_m, left + x, top + y);
                const Floats w = one_depth ? known
                                           : hn::IfThenElse(hn::RebindMask(tag, gap),
                                                            w_from(depths, depths.gap_m, left + x, top + y), known);
                hn::Store(w, tag, pixels.w[y] + x);
                hn::Store(hn::IfThenElse(gap, hn::Set(int_tag, Pixels::open), hn::Set(int_tag, Pixels::coloured)),
                          int_tag, pixels.state[y] + x);
            }
            continue;
        }
        for (int x = 0; x < side; ++x) {
            pixels.rgba[y][x] = 0;
            pixels.w[y][x] = 0;
            pixels.state[y][x] = Pixels::absent;
            if (x >= columns || y >= rows)
                continue;
            const bool gap = *picture.origin.pixel(left + x, top + y) == std::uint8_t(PixelOrigin::gap);
            std::copy_n(picture.rgba.pixel(left + x, top + y), 4, reinterpret_cast<std::uint8_t*>(&pixels.rgba[y][x]));
            pixels.w[y][x] = depths.w_at(gap ? depths.gap_m : depths.known_m, left + x, top + y);
            pixels.state[y][x] = gap ? Pixels::open : Pixels::coloured;
        }
    }
}

using WordTag = hn::RebindToUnsigned<Tag>;

HWY_INLINE Layers children_of(hn::Vec<WordTag> rgba, Floats w, hn::Vec<IntTag> state) {
    const auto channel = [](hn::Vec<WordTag> bits) HWY_ATTR {
        return hn::ConvertTo(tag, hn::BitCast(int_tag, hn::And(bits, hn::Set(WordTag(), 255))));
    };
    return {channel(rgba),
            channel(hn::ShiftRight<8>(rgba)),
            channel(hn::ShiftRight<16>(rgba)),
            w,
            hn::RebindMask(tag, state > hn::Set(int_tag, Pixels::absent)),
            hn::RebindMask(tag, state > hn::Set(int_tag, Pixels::open))};
}

/// Every other pixel of a row is a child of four cells.
HWY_INLINE void children_of_row(const Pixels& pixels, int y, Layers& even, Layers& odd) {
    hn::Vec<WordTag> even_rgba, odd_rgba;
    Floats even_w, odd_w;
    hn::Vec<IntTag> even_state, odd_state;
    hn::LoadInterleaved2(WordTag(), pixels.rgba[y], even_rgba, odd_rgba);
    hn::LoadInterleaved2(tag, pixels.w[y], even_w, odd_w);
    hn::LoadInterleaved2(int_tag, pixels.state[y], even_state, odd_state);
    even = children_of(even_rgba, even_w, even_state);
    odd = children_of(odd_rgba, odd_w, odd_state);
}

HWY_INLINE Floats as_number(Mask mask) {
    return hn::IfThenElseZero(mask, all(1));
}

/// Every other one of eight cells, in two rows of four.
template <typename Pick>
HWY_INLINE Layers picked(const Layers& upper, const Layers& lower, const Pick& pick) {
    const auto number = [&](Mask a, Mask b) HWY_ATTR { return pick(as_number(a), as_number(b)) > all(0); };
    return {pick(upper.r, lower.r),
            pick(upper.g, lower.g),
            pick(upper.b, lower.b),
            pick(upper.w, lower.w),
            number(upper.present, lower.present),
            number(upper.coloured, lower.coloured)};
}

template <int Lane>
HWY_INLINE Layers broadcast(const Layers& layers) {
    const auto one = [](Floats v) HWY_ATTR { return hn::Broadcast<Lane>(v); };
    return {one(layers.r),
            one(layers.g),
            one(layers.b),
            one(layers.w),
            one(as_number(layers.present)) > all(0),
            one(as_number(layers.coloured)) > all(0)};
}

HWY_INLINE void pull_tile(const PullPyramid& pyramid, Tile& tile) {
    const float tolerance = pyramid.depths.tolerance;
    Pixels pixels;
    load_pixels(pyramid, tile, pixels);
    std::array<std::array<Layers, 2>, 4> rows;
    for (int row = 0; row < 4; ++row) {
        std::array<Layers, 4> children;
        children_of_row(pixels, 2 * row, children[0], children[1]);
        children_of_row(pixels, 2 * row + 1, children[2], children[3]);
        rows[std::size_t(row)] = pulled(children, tolerance);
        store(rows[std::size_t(row)], tile.level1, 4 * row);
    }
    const auto even = [](Floats upper, Floats lower) HWY_ATTR { return hn::ConcatEven(tag, lower, upper); };
    const auto odd = [](Floats upper, Floats lower) HWY_ATTR { return hn::ConcatOdd(tag, lower, upper); };
    std::array<Layers, 8> eight;
    for (std::size_t half = 0; half < 2; ++half) {
        eight[half] = picked(rows[0][half], rows[2][half], even);
        eight[2 + half] = picked(rows[0][half], rows[2][half], odd);
        eight[4 + half] = picked(rows[1][half], rows[3][half], even);
        eight[6 + half] = picked(rows[1][half], rows[3][half], odd);
    }
    const std::array<Layers, 2> four = pulled(eight, tolerance);
    store(four, tile.level2, 0);
    for (std::size_t half = 0; half < 2; ++half) {
        eight[half] = broadcast<0>(four[half]);
        eight[2 + half] = broadcast<1>(four[half]);
        eight[4 + half] = broadcast<2>(four[half]);
        eight[6 + half] = broadcast<3>(four[half]);
    }
    store_one(pulled(eight, tolerance), tile.level3);
}

/// Tiles are where gaps are, which nothing but we can foresee: their pixels are asked for early.
HWY_INLINE void ask_for(const PullPyramid& pyramid, const Tile& tile) {
    constexpr int side = PullPyramid::tile_side;
    const EyePicture& picture = *pyramid.picture;
    const int x = tile.column * side, end = std::min((tile.row + 1) * side, picture.origin.height());
    for (int y = tile.row * side; y < end; ++y) {
        hwy::Prefetch(picture.rgba.pixel(x, y));
        hwy::Prefetch(picture.origin.pixel(x, y));
        if (pyramid.depths.known_m.data != nullptr)
            hwy::Prefetch(pyramid.depths.known_m.row(y) + x);
    }
}

void pull_tiles_here(PullPyramid& pyramid, std::size_t first, std::size_t last) {
    constexpr std::size_t ahead = 4;
    for (std::size_t i = first; i < last; ++i) {
        if (i + ahead < last)
            ask_for(pyramid, pyramid.tiles[i + ahead]);
        pull_tile(pyramid, pyramid.tiles[i]);
    }
}

void pull_upper_level_here(PullPyramid& pyramid, int level) {
    PullPyramid::Level& upper = pyramid.upper_levels[std::size_t(level - PullPyramid::tile_levels - 1)];
    for (int y = 0; y < upper.rows; ++y)
        for (int x = 0; x < upper.columns; ++x) {
            PullPyramid::Square<1>& to = upper.cells[std::size_t(y) * upper.columns + x];
            std::array<Layers, 8> children;
            bool any = false;
            for (int k = 0; k < 4; ++k) {
                const PullPyramid::Cell child = pyramid.cell(level - 1, 2 * x + (k & 1), 2 * y + (k >> 1));
                any = any || child.present[0];
                for (std::size_t half = 0; half < 2; ++half) {
                    constexpr Layer none;
                    const Layer& from = !child.present[half] ? none : half == 0 ? *child.far : *child.near;
                    children[2 * std::size_t(k) + half] = {all(from.r),
                                                           all(from.g),
                                                           all(from.b),
                                                           all(from.w),
                                                           mask_of(child.present[half]),
                                                           mask_of(child.coloured[half])};
                }
            }
            if (any)
                store_one(pulled(children, pyramid.depths.tolerance), to);
            else
                to.bits = {};
        }
}

/// The coarser level's layers around places between the same four cells: of columns `right` - 1 and `right`, of the row
/// that holds the places and the row beside it.
class Sampler {
public:
    HWY_INLINE void move_to(const PullPyramid& pyramid, int coarser, int right, int y) {
        right_ = right;
        const int row = y >> 1, beside = row + ((y & 1) != 0 ? 1 : -1);
        add(pyramid.cell(coarser, right - 1, row), 0);
        add(pyramid.cell(coarser, right, row), 2);
        add(pyramid.cell(coarser, right - 1, beside), 4);
        add(pyramid.cell(coarser, right, beside), 6);
    }
    /// Of the cells between which place x lies.
    static int right_of(int x) { return (x + 1) >> 1; }
    int right() const { return right_; }

    /// R, G, B at place x for a layer of this w; false where nothing around has a colour.
    HWY_INLINE bool colour(float tolerance, int x, float w, Floats& rgb) const {
        // Along each axis the cell that holds the place lies nearer (3/4) than the one beside it (1/4).
        const float left = x >> 1 == right_ ? 0.25f : 0.75f;
        const float l = 0.75f * left, r = 0.75f * (1 - left);
        alignas(16) const float near_row[4] = {l, l, r, r};
        const Floats bilinear = hn::Load(tag, near_row);
        const Floats squared = all(tolerance * tolerance);
        alignas(16) float weight[8];
        Floats total = all(0);
        for (int i = 0; i < 8; i += lanes) {
            const Floats apart = hn::Load(tag, w_ + i) - all(w);
            const Floats share = hn::Load(tag, coloured_ + i) * (i == 0 ? bilinear : bilinear * all(1 / 3.0f));
            const Floats one = share * squared / hn::MulAdd(apart, apart, squared);
            hn::Store(one, tag, weight + i);
            total = total + one;
        }
        const float sum = hn::GetLane(hn::SumOfLanes(tag, total));
        if (!(sum > 0))
            return false;
        Floats mean = all(0);
        for (int i = 0; i < 8; ++i)
            mean = hn::MulAdd(all(weight[i]), hn::Load(tag, &layers_[i].r), mean);
        rgb = mean / all(sum);
        return true;
    }

private:
    HWY_INLINE void add(const PullPyramid::Cell& cell, int i) {
        for (int half = 0; half < 2; ++half) {
            const Layer* layer = half == 0 ? cell.far : cell.near;
            const bool coloured = cell.coloured[std::size_t(half)];
            hn::Store(coloured ? hn::LoadU(tag, &layer->r) : all(0), tag, &layers_[i + half].r);
            w_[i + half] = coloured ? layer->w : 0.0f;
            coloured_[i + half] = coloured ? 1.0f : 0.0f;
        }
    }

    int right_ = -1;
    alignas(16) Layer layers_[8];
    alignas(16) float w_[8];
    alignas(16) float coloured_[8];
};

/// Colours the open layers of cell i of a level, which is cell x, y of the picture.
template <std::size_t Cells>
HWY_INLINE void push_cell(const PullPyramid& pyramid, int level, int x, int y, PullPyramid::Square<Cells>& square,
                          int i) {
    Sampler sampler;
    sampler.move_to(pyramid, level + 1, Sampler::right_of(x), y);
    for (std::size_t half = 0; half < 2; ++half) {
        if ((square.bits[half].open() >> i & 1) == 0)
            continue;
        Layer& layer = square.layer[half][std::size_t(i)];
        Floats rgb;
        if (!sampler.colour(pyramid.depths.tolerance, x, layer.w, rgb))
            continue;
        alignas(16) float numbers[4];
        hn::Store(rgb, tag, numbers);
        layer = {numbers[0], numbers[1], numbers[2], layer.w};
        square.bits[half].coloured = std::uint16_t(square.bits[half].coloured | 1u << i);
    }
}

void push_upper_level_here(PullPyramid& pyramid, int level) {
    PullPyramid::Level& upper = pyramid.upper_levels[std::size_t(level - PullPyramid::tile_levels - 1)];
    for (int y = 0; y < upper.rows; ++y)
        for (int x = 0; x < upper.columns; ++x) {
            PullPyramid::Square<1>& cell = upper.cells[std::size_t(y) * upper.columns + x];
            if ((cell.bits[0].open() | cell.bits[1].open()) != 0)
                push_cell(pyramid, level, x, y, cell, 0);
        }
}

template <std::size_t Cells>
HWY_INLINE void push_square(const PullPyramid& pyramid, int level, const Tile& tile,
                            PullPyramid::Square<Cells>& square) {
    const int shift = PullPyramid::tile_levels - level;
    for (unsigned open = square.bits[0].open() | square.bits[1].open(); open != 0; open &= open - 1) {
        const int i = std::countr_zero(open);
        push_cell(pyramid, level, (tile.column << shift) + (i & ((1 << shift) - 1)), (tile.row << shift) + (i >> shift),
                  square, i);
    }
}

void push_tiles_here(PullPyramid& pyramid, int level, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
        Tile& tile = pyramid.tiles[std::size_t(pyramid.tiles_with_gaps[i])];
        if (level == 1)
            push_square(pyramid, level, tile, tile.level1);
        else if (level == 2)
            push_square(pyramid, level, tile, tile.level2);
        else
            push_square(pyramid, level, tile, tile.level3);
    }
}

HWY_INLINE void ask_for(const PullPyramid& pyramid, const GapSpan& span) {
    const EyePicture& picture = *pyramid.picture;
    hwy::Prefetch(picture.rgba.pixel(span.begin, span.y));
    hwy::Prefetch(picture.origin.pixel(span.begin, span.y));
    if (pyramid.depths.gap_m.data != nullptr)
        hwy::Prefetch(pyramid.depths.gap_m.row(span.y) + span.begin);
    const PullPyramid::Cell cell = pyramid.cell(1, span.begin / 2, span.y / 2);
    hwy::Prefetch(cell.far);
    hwy::Prefetch(cell.near);
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

HWY_EXPORT(pull_tiles_here);
HWY_EXPORT(pull_upper_level_here);
HWY_EXPORT(push_upper_level_here);
HWY_EXPORT(push_tiles_here);
HWY_EXPORT(colour_spans_here);

void pull_tiles(PullPyramid& pyramid, std::size_t first, std::size_t last) {
    HWY_DYNAMIC_DISPATCH(pull_tiles_here)(pyramid, first, last);
}
void pull_upper_level(PullPyramid& pyramid, int level) {
    HWY_DYNAMIC_DISPATCH(pull_upper_level_here)(pyramid, level);
}
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
