// The colours at a tile's positions: of a decoder's planes, or of RGB. Apart from warp_kernels.cpp, which calls it,
// so that both compile at once.
#include "resample.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/warp/warp_colour_kernels.cpp"
#include <hwy/foreach_target.h>

#include "warp_colour-inl.h"

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// The cells that a tile's pixels lie in.
struct CellBox {
    int x = 0, y = 0, width = 0, height = 0;
};

/// Of those that are no gaps, brought inside; empty where all are.
HWY_INLINE CellBox box_of(const Tile& tile, LastCell last) {
    Ints min_x = all(last.x), min_y = all(last.y), max_x = all(-1), max_y = all(-1);
    for (int at = 0; at < tile_pixels; at += lanes) {
        const Cells c = brought_inside(hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.u + at)),
                                       hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.v + at)), last);
        if (tile.regular) {
            min_x = hn::Min(min_x, c.x);
            min_y = hn::Min(min_y, c.y);
            max_x = hn::Max(max_x, c.x);
            max_y = hn::Max(max_y, c.y);
        } else {
            const IntMask there = hn::Load(int_tag, tile.keep + at) != all(0);
            min_x = hn::IfThenElse(there, hn::Min(min_x, c.x), min_x);
            min_y = hn::IfThenElse(there, hn::Min(min_y, c.y), min_y);
            max_x = hn::IfThenElse(there, hn::Max(max_x, c.x), max_x);
            max_y = hn::IfThenElse(there, hn::Max(max_y, c.y), max_y);
        }
    }
    const int x = hn::GetLane(hn::MinOfLanes(int_tag, min_x)), y = hn::GetLane(hn::MinOfLanes(int_tag, min_y));
    return {x, y, hn::GetLane(hn::MaxOfLanes(int_tag, max_x)) - x + 1,
            hn::GetLane(hn::MaxOfLanes(int_tag, max_y)) - y + 1};
}

/// A rectangle of the source's samples as RGBA, from its planes (yuv_to_rgb). An eye mostly magnifies the sphere, so
/// that this is less work than mixing each plane for each pixel, and one rounding makes it the same picture as from
/// RGB.
class RgbBlock {
public:
    /// False where the cells need more samples than there is room for, or the planes are too narrow.
    HWY_INLINE bool fill(const YuvView& planes, const CellBox& cells) {
        width_ = (cells.width + 2 + lanes - 1) / lanes * lanes;
        const int height = cells.height + 1;
        if (planes.cb.width < chroma_at_once || planes.y.width < width_ || width_ * height > capacity)
            return false;
        x_ = std::min(cells.x & ~1, planes.y.width - width_);
        y_ = cells.y;
        for (int row = 0; row < height; ++row)
            for (int i = 0; i < width_; i += lanes)
                store_bytes(rgb_from(planes, x_ + i, y_ + row), samples_ + row * width_ + i);
        return true;
    }
    /// Where pixels' first samples lie in it; of gaps anywhere.
    HWY_INLINE void locate(const Tile& tile, const CellBox& cells, std::int32_t* offset) const {
        for (int at = 0; at < tile_pixels; at += lanes) {
            Ints x = hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.u + at));
            Ints y = hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.v + at));
            if (!tile.regular) {
                x = hn::Min(hn::Max(x, all(cells.x)), all(cells.x + cells.width - 1));
                y = hn::Min(hn::Max(y, all(cells.y)), all(cells.y + cells.height - 1));
            }
            hn::Store(hn::ShiftLeft<2>((y - all(y_)) * all(width_) + x - all(x_)), int_tag, offset + at);
        }
    }
    ImageView<const std::uint8_t> view() const {
        return {reinterpret_cast<const std::uint8_t*>(samples_), width_, capacity / width_, 4, 4 * width_};
    }

private:
    static constexpr int chroma_at_once = 16;
    static constexpr int capacity = 4096;

    using Bytes = hn::FixedTag<std::uint8_t, chroma_at_once>;

    /// Chroma less 128, in eighths, of `lanes` samples from an even column on.
    static HWY_INLINE Ints chroma_eighths(const ImageView<const std::uint8_t>& plane, int x, int y) {
        constexpr Bytes bytes;
        const int from = std::min(x / 2, plane.width - chroma_at_once);
        const auto shift = hn::Set(bytes, std::uint8_t(x / 2 - from));
        const auto last = hn::Set(bytes, std::uint8_t(chroma_at_once - 1));
        const auto half = hn::ShiftRight<1>(hn::Iota(bytes, 0)), next = hn::ShiftRight<1>(hn::Iota(bytes, 1));
        const auto near_row = hn::LoadU(bytes, plane.row(y / 2) + from);
        const auto far_row = hn::LoadU(bytes, plane.row(yuv_to_rgb::farther_row(y, plane.height)) + from);
        const auto left = half + shift, right = hn::Min(next + shift, last);
        const auto of = [&](decltype(near_row) row, decltype(left) index)
                            HWY_ATTR { return promoted(bytes, hn::TableLookupBytes(row, index)); };
        const Ints near_sum = of(near_row, left) + of(near_row, right);
        return near_sum + near_sum + near_sum + of(far_row, left) + of(far_row, right) - all(8 * 128);
    }

    /// The first of some bytes.
    template <typename Tag, typename Vector>
    static HWY_INLINE Ints promoted(Tag, Vector values) {
        if constexpr (hn::MaxLanes(Tag()) == lanes) {
            return hn::PromoteTo(int_tag, values);
        } else {
            const hn::Half<Tag> half;
            return promoted(half, hn::LowerHalf(half, values));
        }
    }

    /// The integers of yuv_to_rgb::rgb_at.
    static HWY_INLINE Ints rgb_from(const YuvView& planes, int x, int y) {
        using namespace yuv_to_rgb;
        const auto byte = [](Ints sum)
                              HWY_ATTR { return hn::Min(hn::Max(hn::ShiftRight<sum_bits>(sum), all(0)), all(255)); };
        const Ints luma = hn::PromoteTo(int_tag, hn::LoadU(hn::Rebind<std::uint8_t, IntTag>(), planes.y.row(y) + x));
        const Ints base = luma * all(luma_gain) + all(offset);
        const Ints cb = chroma_eighths(planes.cb, x, y), cr = chroma_eighths(planes.cr, x, y);
        const Ints red = byte(base + cr * all(red_from_cr)), blue = byte(base + cb * all(blue_from_cb));
        const Ints green = byte(base + cb * all(green_from_cb) + cr * all(green_from_cr));
        return hn::Or(red, hn::Or(hn::ShiftLeft<8>(green), hn::ShiftLeft<16>(blue)));
    }

    int x_ = 0, y_ = 0, width_ = 0;
    alignas(64) std::uint32_t samples_[capacity];
};

/// Some pixels have samples outside of the plane; bits as of locate.
HWY_INLINE std::uint32_t outside_of(const Tile& tile, const ImageView<const std::uint8_t>& plane) {
    std::uint32_t outside = 0;
    for (int at = 0; at < tile_pixels && !tile.regular; at += lanes) {
        const Cells cells =
            brought_inside(hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.u + at)),
                           hn::ShiftRight<position_bits>(hn::Load(int_tag, tile.v + at)), last_cell(plane));
        outside |= hn::AllFalse(int_tag, cells.outside) ? 0u : 1u << (at / lanes);
    }
    return outside;
}

/// A decoder's planes.
HWY_INLINE void mix_yuv(const WarpJob& job, const Tile& tile, const PixelRows& to) {
    const YuvView& planes = job.source.yuv;
    Mixture mixture;
    weigh(tile, mixture);
    std::uint32_t one_by_one = all_groups;
    if (!too_small(planes.y)) {
        const CellBox cells = box_of(tile, last_cell(planes.y));
        RgbBlock block;
        if (cells.width > 0 && block.fill(planes, cells)) {
            block.locate(tile, cells, mixture.offset);
            mix_samples(block.view(), mixture, tile.rows, to);
            one_by_one = outside_of(tile, planes.y);
        }
    }
    for_each_pixel(tile, one_by_one, [&](int i) {
        to.set(i, mixed_one_by_one(job.grid, tile, i, mixture.weights[i],
                                   [&](int x, int y) { return yuv_to_rgb::rgb_at(planes, x, y); }));
    });
}

std::int64_t colour(const WarpJob& job, const Tile& tile) {
    const auto mix = [&](const PixelRows& to)
                         HWY_ATTR { job.source.rgb.data != nullptr ? mix_rgb(job, tile, to) : mix_yuv(job, tile, to); };
    if (tile.regular && tile.columns == tile_width) {
        mix({job.rgba.pixel(tile.x, tile.y), job.rgba.row_stride});
        return put_marks(job, tile);
    }
    alignas(64) std::uint32_t pixels[tile_pixels];
    mix({reinterpret_cast<std::uint8_t*>(pixels), 4 * tile_width});
    return put(job, tile, pixels);
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
