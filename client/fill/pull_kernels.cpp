// The pull of push_pull.h: from pixels up, one layer of four cells at once.
#include "push_pull.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/fill/pull_kernels.cpp"
#include <hwy/foreach_target.h>

#include "push_pull-inl.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

HWY_INLINE FloatMask never() {
    return all(0) > all(1);
}
HWY_INLINE FloatMask mask_of(bool set) {
    return all(set ? 1.0f : 0.0f) > all(0);
}

/// One layer of four cells.
struct Layers {
    Floats r, g, b, w;
    FloatMask present, coloured;  ///< coloured: only where present
};

HWY_INLINE Layers no_layers() {
    return {all(0), all(0), all(0), all(0), never(), never()};
}

/// Of layers that are there and have a colour.
template <std::size_t Children>
HWY_INLINE Layers mean_of(const std::array<Layers, Children>& children) {
    Layers sum = children[0];
    for (std::size_t i = 1; i < Children; ++i) {
        sum.r = sum.r + children[i].r;
        sum.g = sum.g + children[i].g;
        sum.b = sum.b + children[i].b;
        sum.w = sum.w + children[i].w;
    }
    const Floats share = all(1 / float(Children));
    return {sum.r * share, sum.g * share, sum.b * share, sum.w * share, sum.present, sum.coloured};
}

/// The pull of push_pull.h: far and near.
template <std::size_t Children>
HWY_INLINE std::array<Layers, 2> pulled(const std::array<Layers, Children>& children, float tolerance) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Floats low = all(infinity), high = all(-infinity);
    for (const Layers& child : children) {
        low = hn::Min(low, hn::IfThenElse(child.present, child.w, all(infinity)));
        high = hn::Max(high, hn::IfThenElse(child.present, child.w, all(-infinity)));
    }
    const FloatMask alike = high - low <= all(tolerance);
    FloatMask coloured_all = children[0].coloured;
    for (const Layers& child : children)
        coloured_all = hn::And(coloured_all, child.coloured);
    if (hn::AllTrue(tag, hn::And(alike, coloured_all)))
        return {mean_of(children), no_layers()};
    const Floats split = formulas::split_between(low, high, tolerance);
    std::array<Layers, 2> halves;
    for (int half = 0; half < 2; ++half) {
        Layers& sum = halves[std::size_t(half)];
        sum = no_layers();
        if (half == 1 && hn::AllTrue(tag, alike))
            break;
        Floats present = all(0), coloured = all(0);
        for (const Layers& child : children) {
            const FloatMask here = hn::And(child.present, half == 0 ? child.w <= split : child.w > split);
            const FloatMask shown = hn::And(here, child.coloured);
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

HWY_INLINE unsigned bits_of(FloatMask mask) {
    std::uint8_t bits[8];
    hn::StoreMaskBits(tag, mask, bits);
    return bits[0];
}

/// Four cells of a level from the `first` on.
template <std::size_t Cells>
HWY_INLINE void store(const std::array<Layers, 2>& halves, PullPyramid::Layers<Cells>& to, PullPyramid::LayerBits& bits,
                      int first) {
    for (std::size_t half = 0; half < 2; ++half) {
        const unsigned present = bits_of(halves[half].present);
        if (first == 0)
            bits[half] = {};
        if (present == 0)
            continue;
        bits[half].present = std::uint16_t(bits[half].present | present << first);
        bits[half].coloured = std::uint16_t(bits[half].coloured | bits_of(halves[half].coloured) << first);
        hn::StoreInterleaved4(halves[half].r, halves[half].g, halves[half].b, halves[half].w, tag,
                              &to[half][std::size_t(first)].r);
    }
}

/// Of cells that are four times the same.
HWY_INLINE void store_one(const std::array<Layers, 2>& halves, PullPyramid::OneCell& cell) {
    PullPyramid::Layers<4> four;
    store(halves, four, cell.bits, 0);
    for (std::size_t half = 0; half < 2; ++half) {
        cell.layers[half][0] = four[half][0];
        cell.bits[half] = {std::uint16_t(cell.bits[half].present & 1), std::uint16_t(cell.bits[half].coloured & 1)};
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
    return hn::IfThenElseZero(depth > all(0), Floats(formulas::w_of(depth, depths.box_radius_m)));
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

HWY_INLINE Floats as_number(FloatMask mask) {
    return hn::IfThenElseZero(mask, all(1));
}

/// Every other one of eight cells, in two rows of four.
template <typename Pick>
HWY_INLINE Layers picked(const Layers& upper, const Layers& lower, const Pick& pick) {
    const auto number = [&](FloatMask a, FloatMask b) HWY_ATTR { return pick(as_number(a), as_number(b)) > all(0); };
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

/// From the four children's layers, of which near ones are rare.
HWY_INLINE std::array<Layers, 2> pulled_from(const std::array<std::array<Layers, 4>, 2>& children, float tolerance) {
    FloatMask near = never();
    for (const Layers& child : children[1])
        near = hn::Or(near, child.present);
    if (hn::AllFalse(tag, near))
        return pulled(children[0], tolerance);
    std::array<Layers, 8> both;
    for (std::size_t i = 0; i < 8; ++i)
        both[i] = children[i / 4][i % 4];
    return pulled(both, tolerance);
}

HWY_INLINE void pull_tile(const PullPyramid& pyramid, Tile& tile, PullPyramid::TileLayers& layers) {
    const float tolerance = pyramid.depths.tolerance;
    Pixels pixels;
    load_pixels(pyramid, tile, pixels);
    std::array<std::array<Layers, 2>, 4> rows;
    for (int row = 0; row < 4; ++row) {
        std::array<Layers, 4> children;
        children_of_row(pixels, 2 * row, children[0], children[1]);
        children_of_row(pixels, 2 * row + 1, children[2], children[3]);
        rows[std::size_t(row)] = pulled(children, tolerance);
        store(rows[std::size_t(row)], layers.level1, tile.bits1, 4 * row);
    }
    const auto even = [](Floats upper, Floats lower) HWY_ATTR { return hn::ConcatEven(tag, lower, upper); };
    const auto odd = [](Floats upper, Floats lower) HWY_ATTR { return hn::ConcatOdd(tag, lower, upper); };
    std::array<std::array<Layers, 4>, 2> children;
    for (std::size_t half = 0; half < 2; ++half)
        children[half] = {picked(rows[0][half], rows[2][half], even), picked(rows[0][half], rows[2][half], odd),
                          picked(rows[1][half], rows[3][half], even), picked(rows[1][half], rows[3][half], odd)};
    const std::array<Layers, 2> four = pulled_from(children, tolerance);
    store(four, layers.level2, tile.bits2, 0);
    for (std::size_t half = 0; half < 2; ++half)
        children[half] = {broadcast<0>(four[half]), broadcast<1>(four[half]), broadcast<2>(four[half]),
                          broadcast<3>(four[half])};
    store_one(pulled_from(children, tolerance), tile.level3);
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
        pull_tile(pyramid, pyramid.tiles[i], pyramid.tile_layers[i]);
    }
}

void pull_upper_level_here(PullPyramid& pyramid, int level) {
    PullPyramid::Level& upper = pyramid.upper_levels[std::size_t(level - PullPyramid::tile_levels - 1)];
    for (int y = 0; y < upper.rows; ++y)
        for (int x = 0; x < upper.columns; ++x) {
            PullPyramid::OneCell& to = upper.cells[std::size_t(y) * upper.columns + x];
            std::array<std::array<Layers, 4>, 2> children;
            bool any = false;
            for (int k = 0; k < 4; ++k) {
                const PullPyramid::Cell child = pyramid.cell(level - 1, 2 * x + (k & 1), 2 * y + (k >> 1));
                any = any || child.present[0];
                for (std::size_t half = 0; half < 2; ++half) {
                    constexpr Layer none;
                    const Layer& from = !child.present[half] ? none : half == 0 ? *child.far : *child.near;
                    children[half][std::size_t(k)] = {all(from.r),
                                                      all(from.g),
                                                      all(from.b),
                                                      all(from.w),
                                                      mask_of(child.present[half]),
                                                      mask_of(child.coloured[half])};
                }
            }
            if (any)
                store_one(pulled_from(children, pyramid.depths.tolerance), to);
            else
                to.bits = {};
        }
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace equistream {

HWY_EXPORT(pull_tiles_here);
HWY_EXPORT(pull_upper_level_here);

void pull_tiles(PullPyramid& pyramid, std::size_t first, std::size_t last) {
    HWY_DYNAMIC_DISPATCH(pull_tiles_here)(pyramid, first, last);
}
void pull_upper_level(PullPyramid& pyramid, int level) {
    HWY_DYNAMIC_DISPATCH(pull_upper_level_here)(pyramid, level);
}

}  // namespace equistream
#endif
