// The colours at a tile's positions: weights, and samples of RGB or RGBA; and tiles into pictures.
#if defined(EQUISTREAM_WARP_COLOUR_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_WARP_COLOUR_INL_H
#undef EQUISTREAM_WARP_COLOUR_INL_H
#else
#define EQUISTREAM_WARP_COLOUR_INL_H
#endif

#include "warp_positions-inl.h"

#include <array>
#include <bit>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// What mixing needs of each pixel of a tile: where its first sample lies, in bytes from the plane's beginning, and the
/// weights of the four, a byte each and 128 together, the first one lowest.
struct Mixture {
    alignas(64) std::int32_t offset[tile_pixels];
    alignas(64) std::uint32_t weights[tile_pixels];
};

/// 128 shared out to the samples that are kept; which of the four those are says `keep`, bit by bit.
HWY_INLINE Ints weights_of_kept(Ints keep, const std::array<Ints, 4>& whole) {
    std::array<Floats, 4> upto{};
    Floats sum = all(0.0f);
    for (int k = 0; k < 4; ++k) {
        const IntMask kept = hn::TestBit(keep, all(1 << k));
        sum = sum + hn::ConvertTo(float_tag, hn::IfThenElseZero(kept, whole[k]));
        upto[k] = sum;
    }
    const Floats scale = hn::IfThenElse(sum > all(0.0f), all(float(position_one)) / sum, all(0.0f));
    Ints packed = all(0), before = all(0);
    for (int k = 0; k < 4; ++k) {
        const Ints rounded = hn::NearestInt(upto[k] * scale);  // of the running sum, so that nothing is lost
        packed = hn::Or(packed, hn::Shl(rounded - before, all(8 * k)));
        before = rounded;
    }
    return packed;
}

struct Fractions {
    Ints u, v;
};

HWY_INLINE std::array<Ints, 4> bilinear_weights(const Fractions& f) {
    const Ints both = hn::ShiftRight<position_bits>(f.u * f.v + all(position_one / 2));
    return {all(position_one) - f.u - f.v + both, f.u - both, f.v - both, both};
}

HWY_INLINE Ints packed(const std::array<Ints, 4>& w) {
    return hn::Or(hn::Or(w[0], hn::ShiftLeft<8>(w[1])), hn::Or(hn::ShiftLeft<16>(w[2]), hn::ShiftLeft<24>(w[3])));
}

/// The last of each that a sample with three others to its right and below may have, in a plane read by pairs.
struct LastCell {
    int x, y;
};

/// Eight bytes are read where three-byte samples begin: two more than a pair has.
inline LastCell last_cell(const ImageView<const std::uint8_t>& plane) {
    return {plane.width - (plane.channels == 3 ? 3 : 2), plane.height - 2};
}

/// No sample of it can be read like that.
inline bool too_small(const ImageView<const std::uint8_t>& plane) {
    return last_cell(plane).x < 0 || last_cell(plane).y < 0;
}

inline constexpr std::uint32_t all_groups = 0xffffffffu >> (32 - tile_pixels / lanes);

/// Positions' first samples; those that do not have all four inside are brought there, to be mixed again one by one.
struct Cells {
    Ints x, y;
    IntMask outside;
};

HWY_INLINE Cells brought_inside(Ints x, Ints y, LastCell last) {
    const Ints cx = hn::Min(hn::Max(x, all(0)), all(last.x));
    const Ints cy = hn::Min(hn::Max(y, all(0)), all(last.y));
    return {cx, cy, hn::Or(cx != x, cy != y)};
}

HWY_INLINE void store_bytes(Ints bytes, std::uint32_t* to) {
    const hn::RebindToUnsigned<IntTag> tag;
    hn::Store(hn::BitCast(tag, bytes), tag, to);
}

/// Weights of the four samples of each pixel, and where the first one lies.
HWY_INLINE void weigh(const Tile& tile, Mixture& mixture) {
    for (int at = 0; at < tile_pixels; at += lanes) {
        const Ints u = hn::Load(int_tag, tile.u + at), v = hn::Load(int_tag, tile.v + at);
        const std::array<Ints, 4> weights =
            bilinear_weights({hn::And(u, all(position_one - 1)), hn::And(v, all(position_one - 1))});
        Ints bytes = packed(weights);
        if (!tile.regular) {
            const Ints keep = hn::Load(int_tag, tile.keep + at);
            const IntMask whole = hn::Or(keep == all(15), keep == all(0));
            if (!hn::AllTrue(int_tag, whole))
                bytes = hn::IfThenElse(whole, bytes, weights_of_kept(keep, weights));
        }
        store_bytes(bytes, mixture.weights + at);
    }
}

/// Offsets in bytes of the first samples; bit i of the result: the pixels from i lanes on are not all inside.
HWY_INLINE std::uint32_t locate(const Tile& tile, const ImageView<const std::uint8_t>& plane, std::int32_t* offset) {
    if (too_small(plane))
        return all_groups;
    const Ints stride = all(int(plane.row_stride)), step = all(plane.channels);
    std::uint32_t outside = 0;
    for (int at = 0; at < tile_pixels; at += lanes) {
        Ints x = hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.u + at));
        Ints y = hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.v + at));
        if (!tile.regular) {
            const Cells cells = brought_inside(x, y, last_cell(plane));
            outside |= hn::AllFalse(int_tag, cells.outside) ? 0u : 1u << (at / lanes);
            x = cells.x;
            y = cells.y;
        }
        hn::Store(y * stride + x * step, int_tag, offset + at);
    }
    return outside;
}

inline constexpr std::uint32_t opaque = 0xff000000;

/// Four samples of one pixel, wherever they lie; `colour(x, y)` gives R, G, B of any sample of the source.
template <typename Colour>
std::uint32_t mixed_one_by_one(const SourceGrid& grid, const Tile& tile, int pixel, std::uint32_t weights,
                               const Colour& colour) {
    std::array<int, 3> sum{};
    for (int k = 0; k < 4; ++k) {
        const Sample s =
            wrapped(grid, (tile.u[pixel] >> position_bits) + (k & 1), (tile.v[pixel] >> position_bits) + (k >> 1));
        const auto sample = colour(s.x, s.y);
        for (std::size_t c = 0; c < 3; ++c)
            sum[c] += int(weights >> (8 * k) & 0xff) * sample[c];
    }
    std::uint32_t rgb = opaque;
    for (std::size_t c = 0; c < 3; ++c)
        rgb |= std::uint32_t((sum[c] + position_one / 2) >> position_bits) << (8 * c);
    return rgb;
}

/// Where a tile's pixels go as opaque RGBA: into the picture, or beside it.
struct PixelRows {
    std::uint8_t* first;
    std::ptrdiff_t stride;

    std::uint8_t* row(int y) const { return first + y * stride; }
    void set(int pixel, std::uint32_t rgba) const {
        std::memcpy(row(pixel / tile_width) + 4 * (pixel % tile_width), &rgba, 4);
    }
};

/// Calls `redo(i)` for the pixels of the groups of lanes that `groups` names, where they are no gaps.
template <typename Redo>
HWY_INLINE void for_each_pixel(const Tile& tile, std::uint32_t groups, const Redo& redo) {
    for (; groups != 0; groups &= groups - 1) {
        const int from = lanes * std::countr_zero(groups), end = std::min(from + lanes, tile.rows * tile_width);
        for (int i = from; i < end; ++i)
            if (tile.regular || tile.keep[i] != 0)
                redo(i);
    }
}

/// A tile's rows from RGB or RGBA samples whose offsets and weights are known.
HWY_INLINE void mix_samples(const ImageView<const std::uint8_t>& plane, const Mixture& mixture, int rows,
                            const PixelRows& to) {
    const hn::CappedTag<std::uint8_t, 64> bytes;
    const hn::Repartition<std::uint64_t, decltype(bytes)> eights;
    const hn::Rebind<std::uint32_t, decltype(eights)> fours;
    const hn::RepartitionToWide<hn::RebindToSigned<decltype(bytes)>> sums;
    const hn::Rebind<std::uint8_t, decltype(sums)> narrow;
    alignas(16) static constexpr std::uint8_t upper[16] = {0, 1, 0, 1, 0, 1, 0, 1, 8, 9, 8, 9, 8, 9, 8, 9};
    alignas(16) static constexpr std::uint8_t lower[16] = {2, 3, 2, 3, 2, 3, 2, 3, 10, 11, 10, 11, 10, 11, 10, 11};
    alignas(16) static constexpr std::uint8_t of_four[16] = {0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15};
    alignas(16) static constexpr std::uint8_t of_three[16] = {0, 3, 1, 4, 2, 5, 2, 5, 8, 11, 9, 12, 10, 13, 10, 13};
    const auto by_channel = hn::LoadDup128(bytes, plane.channels == 4 ? of_four : of_three);
    const auto upper_weights = hn::LoadDup128(bytes, upper), lower_weights = hn::LoadDup128(bytes, lower);
    const auto sign = hn::Set(bytes, 0x80);
    const std::uint8_t* first_row = plane.data;
    const std::uint8_t* second_row = plane.data + plane.row_stride;
    const auto mixed = [&](int at) HWY_ATTR {
        const auto weights = hn::BitCast(bytes, hn::PromoteTo(eights, hn::Load(fours, mixture.weights + at)));
        const auto row = [&](const std::uint8_t* base, decltype(by_channel) pick) HWY_ATTR {
            const auto pairs = hn::TableLookupBytes(load_eights(bytes, base, mixture.offset + at), by_channel);
            return weighted_pairs(bytes, hn::TableLookupBytes(weights, pick), hn::Xor(pairs, sign));
        };
        const auto sum = row(first_row, upper_weights) + row(second_row, lower_weights);
        const auto rounded = hn::ShiftRight<position_bits>(sum + hn::Set(sums, position_one / 2));
        return hn::Or(hn::BitCast(fours, hn::DemoteTo(narrow, rounded + hn::Set(sums, 128))), hn::Set(fours, opaque));
    };
    for (int y = 0; y < rows; ++y)
        for (int i = 0; i < tile_width; i += int(hn::MaxLanes(eights)))
            hn::StoreU(hn::BitCast(narrow, mixed(y * tile_width + i)), narrow, to.row(y) + 4 * i);
}

/// RGB or RGBA samples.
HWY_INLINE void mix_rgb(const WarpJob& job, const Tile& tile, const PixelRows& to) {
    const ImageView<const std::uint8_t>& plane = job.source.rgb;
    Mixture mixture;
    weigh(tile, mixture);
    const std::uint32_t outside = locate(tile, plane, mixture.offset);
    if (!too_small(plane)) {
        ask_ahead(plane.data, plane.row_stride, mixture.offset);
        mix_samples(plane, mixture, tile.rows, to);
    }
    for_each_pixel(tile, outside, [&](int i) {
        to.set(i, mixed_one_by_one(job.grid, tile, i, mixture.weights[i],
                                   [&](int x, int y) { return plane.pixel(x, y); }));
    });
}

/// A whole tile into the picture; how many of its pixels have a colour.
HWY_INLINE std::int64_t put(const WarpJob& job, const Tile& tile, const std::uint32_t* pixels) {
    std::int64_t count = 0;
    for (int row = 0; row < tile.rows; ++row) {
        std::uint8_t* rgba = job.rgba.pixel(tile.x, tile.y + row);
        std::uint8_t* origin = job.origin.pixel(tile.x, tile.y + row);
        if (tile.columns == tile_width && !job.only_gaps) {
            const hn::RebindToUnsigned<IntTag> tag;
            const hn::Rebind<std::uint8_t, IntTag> marks;
            for (int i = 0; i < tile_width; i += lanes) {
                const int at = row * tile_width + i;
                const IntMask shown = hn::Load(int_tag, tile.keep + at) != all(0);
                const auto out = hn::IfThenElseZero(hn::RebindMask(tag, shown), hn::Load(tag, pixels + at));
                hn::StoreU(hn::BitCast(hn::Repartition<std::uint8_t, IntTag>(), out),
                           hn::Repartition<std::uint8_t, IntTag>(), rgba + 4 * i);
                hn::StoreU(hn::DemoteTo(marks, hn::IfThenElseZero(shown, all(int(job.mark)))), marks, origin + i);
                count += std::int64_t(hn::CountTrue(int_tag, shown));
            }
            continue;
        }
        for (int i = 0; i < tile.columns; ++i) {
            const bool shown = tile.regular || tile.keep[row * tile_width + i] != 0;
            if (!shown && job.only_gaps)
                continue;
            const std::uint32_t colour = shown ? pixels[row * tile_width + i] : 0;
            std::memcpy(rgba + 4 * i, &colour, 4);
            origin[i] = std::uint8_t(shown ? job.mark : PixelOrigin::gap);
            count += shown;
        }
    }
    return count;
}

/// Its origins alone: of all pixels the mark.
HWY_INLINE std::int64_t put_marks(const WarpJob& job, const Tile& tile) {
    for (int row = 0; row < tile.rows; ++row)
        std::memset(job.origin.pixel(tile.x, tile.y + row), int(job.mark), tile_width);
    return std::int64_t{tile.rows} * tile_width;
}

/// The colours at a tile's positions into the picture; how many of its pixels have one (warp_colour_kernels.cpp).
std::int64_t colour(const WarpJob& job, const Tile& tile);

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
