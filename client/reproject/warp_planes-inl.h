// The colours at a tile's positions: of a decoder's planes.
#if defined(EQUISTREAM_WARP_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_WARP_PLANES_INL_H
#undef EQUISTREAM_WARP_PLANES_INL_H
#else
#define EQUISTREAM_WARP_PLANES_INL_H
#endif

#include "warp_colour-inl.h"

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// The four samples of each pixel as bytes of one number, in the order of the weights.
inline void collect(const ImageView<const std::uint8_t>& plane, const std::int32_t* offset, std::int32_t* samples) {
    const std::uint8_t* first_row = plane.data;
    const std::uint8_t* second_row = plane.data + plane.row_stride;
    for (int i = 0; i < tile_pixels; ++i) {
        std::uint16_t above, below;
        std::memcpy(&above, first_row + offset[i], 2);
        std::memcpy(&below, second_row + offset[i], 2);
        samples[i] = std::int32_t(above | std::uint32_t(below) << 16);
    }
}

/// 128 times what the weights make of the samples, less 128 each.
HWY_INLINE Ints mixed(Ints samples, const std::uint32_t* weights) {
    const hn::Repartition<std::uint8_t, IntTag> bytes;
    const auto s = hn::Xor(hn::BitCast(bytes, samples), hn::Set(bytes, 0x80));
    const auto w = hn::BitCast(bytes, hn::Load(hn::RebindToUnsigned<IntTag>(), weights));
    const Ints pairs = hn::BitCast(int_tag, weighted_pairs(bytes, w, s));
    return hn::ShiftRight<16>(hn::ShiftLeft<16>(pairs)) + hn::ShiftRight<16>(pairs);
}

/// The cells of chroma that a tile's pixels fall into: mostly few, as an eye magnifies the sphere and chroma has a
/// quarter of its samples. Each cell's samples are collected once, for all pixels in it.
class ChromaCells {
public:
    /// Chroma's planes have one size; `tile` holds positions among their samples.
    HWY_INLINE void collect_from(const YuvView& planes, const Tile& tile) {
        const LastCell last = last_cell(planes.cb);
        Ints least_x = all(last.x), least_y = all(last.y), most_x = all(0), most_y = all(0);
        for (int at = 0; at < tile_pixels; at += lanes) {
            const Cells c = brought_inside(hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.u + at)),
                                           hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.v + at)), last);
            least_x = hn::Min(least_x, c.x);
            least_y = hn::Min(least_y, c.y);
            most_x = hn::Max(most_x, c.x);
            most_y = hn::Max(most_y, c.y);
        }
        const int x = hn::GetLane(hn::MinOfLanes(int_tag, least_x)), y = hn::GetLane(hn::MinOfLanes(int_tag, least_y));
        const int width = hn::GetLane(hn::MaxOfLanes(int_tag, most_x)) - x + 1;
        const int height = hn::GetLane(hn::MaxOfLanes(int_tag, most_y)) - y + 1;
        if (width * height > tile_pixels)
            collect_each(planes, tile);
        else
            collect_block(planes, tile, {x, y}, width, height);
    }
    /// The samples of some pixels, in the order of weights.
    HWY_INLINE void at(int pixel, Ints& cb, Ints& cr) const {
        const hn::Repartition<std::uint8_t, IntTag> bytes;
        const auto* base = reinterpret_cast<const std::uint8_t*>(cells_);
        const Ints low = hn::BitCast(int_tag, load_eights(bytes, base, offset_ + pixel));
        const Ints high = hn::BitCast(int_tag, load_eights(bytes, base, offset_ + pixel + lanes / 2));
        cb = hn::ConcatEven(int_tag, high, low);
        cr = hn::ConcatOdd(int_tag, high, low);
    }

private:
    static std::uint32_t four(const ImageView<const std::uint8_t>& plane, int x, int y) {
        std::uint16_t above, below;
        const std::uint8_t* first = plane.data + y * plane.row_stride + x;
        std::memcpy(&above, first, 2);
        std::memcpy(&below, first + plane.row_stride, 2);
        return above | std::uint32_t(below) << 16;
    }
    static std::uint64_t cell(const YuvView& planes, int x, int y) {
        return four(planes.cb, x, y) | std::uint64_t(four(planes.cr, x, y)) << 32;
    }
    HWY_INLINE void collect_block(const YuvView& planes, const Tile& tile, Sample first, int width, int height) {
        const LastCell last = last_cell(planes.cb);
        for (int i = 0; i < width * height; ++i)
            cells_[i] = cell(planes, first.x + i % width, first.y + i / width);
        for (int at = 0; at < tile_pixels; at += lanes) {
            const Cells c = brought_inside(hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.u + at)),
                                           hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.v + at)), last);
            const Ints index = (c.y - all(first.y)) * all(width) + c.x - all(first.x);
            hn::Store(hn::ShiftLeft<3>(index), int_tag, offset_ + at);
        }
    }
    HWY_INLINE void collect_each(const YuvView& planes, const Tile& tile) {
        const LastCell last = last_cell(planes.cb);
        for (int i = 0; i < tile_pixels; ++i) {
            cells_[i] = cell(planes, std::clamp(tile.u[i] >> position_bits, 0, last.x),
                             std::clamp(tile.v[i] >> position_bits, 0, last.y));
            offset_[i] = 8 * i;
        }
    }

    alignas(64) std::uint64_t cells_[tile_pixels];
    alignas(64) std::int32_t offset_[tile_pixels];
};

/// Some pixels have samples outside of the plane; bits as of locate.
HWY_INLINE std::uint32_t outside_of(const Tile& tile, const ImageView<const std::uint8_t>& plane) {
    if (too_small(plane))
        return all_groups;
    std::uint32_t outside = 0;
    for (int at = 0; at < tile_pixels && !tile.regular; at += lanes) {
        const Cells cells =
            brought_inside(hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.u + at)),
                           hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.v + at)), last_cell(plane));
        outside |= hn::AllFalse(int_tag, cells.outside) ? 0u : 1u << (at / lanes);
    }
    return outside;
}

/// Where pixels lie among the samples of chroma: columns on luma's even ones, rows between two of luma's. Positions are
/// where the kept samples' middle is, so that an edge in depth takes chroma from its own side.
HWY_INLINE void map_chroma(const Tile& tile, const Mixture& luma, Tile& chroma) {
    const hn::RebindToUnsigned<IntTag> tag;
    for (int at = 0; at < tile_pixels; at += lanes) {
        const Ints w = hn::BitCast(int_tag, hn::Load(tag, luma.weights + at));
        const Ints last = hn::BitCast(int_tag, hn::ShiftRight<24>(hn::BitCast(tag, w)));
        const Ints right = hn::And(hn::ShiftRight<8>(w), all(0xff)) + last;
        const Ints below = hn::And(hn::ShiftRight<16>(w), all(0xff)) + last;
        const Ints u = hn::AndNot(all(position_one - 1), hn::Load(int_tag, tile.u + at)) + right;
        const Ints v = hn::AndNot(all(position_one - 1), hn::Load(int_tag, tile.v + at)) + below;
        hn::Store(hn::ShiftRight<1>(u), int_tag, chroma.u + at);
        hn::Store(hn::ShiftRight<1>(v - all(position_one / 2)), int_tag, chroma.v + at);
    }
}

/// Steps of luma above black and of chroma off grey, to bytes R, G, B of one number (yuv.h).
HWY_INLINE Ints rgb_of_steps(Floats y, Floats cb, Floats cr) {
    using namespace bt709;
    const auto byte = [](Floats value)
                          HWY_ATTR { return hn::NearestInt(hn::Min(hn::Max(value, all(0.0f)), all(255.0f))); };
    const Floats grey = y * all(float(1 / luma_scale));
    const Floats r = hn::MulAdd(cr, all(float(cr_divisor / chroma_scale)), grey);
    const Floats b = hn::MulAdd(cb, all(float(cb_divisor / chroma_scale)), grey);
    const Floats g = hn::MulAdd(cb, all(float(green_from_cb / chroma_scale)),
                                hn::MulAdd(cr, all(float(green_from_cr / chroma_scale)), grey));
    return hn::Or(byte(r), hn::Or(hn::ShiftLeft<8>(byte(g)), hn::ShiftLeft<16>(byte(b))));
}

/// A decoder's planes, each sampled where it has its samples; bytes as of mix_rgb.
HWY_INLINE void mix_yuv(const WarpJob& job, const Tile& tile, std::uint32_t* pixels) {
    const YuvView& planes = job.source.yuv;
    Mixture luma, chroma;
    weigh(tile, luma);
    Tile chroma_tile;
    chroma_tile.regular = tile.regular;
    map_chroma(tile, luma, chroma_tile);
    std::fill_n(chroma_tile.keep, tile_pixels, 15);
    weigh(chroma_tile, chroma);
    const std::uint32_t outside_luma = locate(tile, planes.y, luma.offset);
    const std::uint32_t outside_chroma = outside_of(chroma_tile, planes.cb);

    if (!too_small(planes.y) && !too_small(planes.cb)) {
        alignas(64) std::int32_t y[tile_pixels];
        ask_ahead(planes.y.data, luma.offset);
        collect(planes.y, luma.offset, y);
        ChromaCells cells;
        cells.collect_from(planes, chroma_tile);
        const Floats unit = all(1.0f / position_one);
        const auto steps = [&](Ints sum) HWY_ATTR { return hn::ConvertTo(float_tag, sum) * unit; };
        for (int at = 0; at < tile_pixels; at += lanes) {
            Ints cb, cr;
            cells.at(at, cb, cr);
            const Floats above_black = steps(mixed(hn::Load(int_tag, y + at), luma.weights + at)) + all(128.0f - 16.0f);
            store_bytes(
                rgb_of_steps(above_black, steps(mixed(cb, chroma.weights + at)), steps(mixed(cr, chroma.weights + at))),
                pixels + at);
        }
    }
    for_each_pixel(tile, outside_luma | outside_chroma, [&](int i) HWY_ATTR {
        const auto value = [&](const Tile& t, const Mixture& m, const ImageView<const std::uint8_t>& plane) HWY_ATTR {
            const Sample first{t.u[i] >> position_bits, t.v[i] >> position_bits};
            return float(mixed_one_by_one(job.grid, plane, first, m.weights[i], 0)) / position_one;
        };
        alignas(64) std::uint32_t rgb[lanes];
        store_bytes(rgb_of_steps(all(value(tile, luma, planes.y) - 16),
                                 all(value(chroma_tile, chroma, planes.cb) - 128),
                                 all(value(chroma_tile, chroma, planes.cr) - 128)),
                    rgb);
        pixels[i] = rgb[0];
    });
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
