// Planes of a whole picture that the map's rows are judged by: differences to what is beside a pixel, steps along
// columns. Included once for each instruction set.
#if defined(EQUISTREAM_MAP_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_MAP_PLANES_INL_H
#undef EQUISTREAM_MAP_PLANES_INL_H
#else
#define EQUISTREAM_MAP_PLANES_INL_H
#endif

#include "map_rows-inl.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// The worst of three channels of each pixel, as bytes.
template <typename Bytes>
HWY_INLINE auto worst_channel(Bytes rgba) {
    const hn::RebindToUnsigned<IntTag> pixel_tag;
    const auto pixels = hn::BitCast(pixel_tag, rgba);
    const hn::Repartition<std::uint8_t, IntTag> tag;
    const auto worst = hn::Max(
        rgba, hn::Max(hn::BitCast(tag, hn::ShiftRight<8>(pixels)), hn::BitCast(tag, hn::ShiftRight<16>(pixels))));
    return hn::U8FromU32(hn::And(hn::BitCast(pixel_tag, worst), hn::Set(pixel_tag, 0xff)));
}

template <typename Bytes>
HWY_INLINE Bytes difference(Bytes a, Bytes b) {
    return hn::Or(hn::SaturatedSub(a, b), hn::SaturatedSub(b, a));
}

struct EdgeDifferences {
    std::uint8_t contrast = 0, bend = 0;

    void widen(const std::uint8_t* here, const std::uint8_t* before, const std::uint8_t* after) {
        for (int c = 0; c < 3; ++c) {
            const int h = here[c], a = before[c], b = after[c];
            contrast = std::uint8_t(std::max({int(contrast), std::abs(h - a), std::abs(h - b)}));
            bend = std::uint8_t(std::max(int(bend), std::abs(h - (a + b + 1) / 2)));
        }
    }
};

bool find_differences_here(const MapJob& job, int first, int last) {
    const ByteImage& rgba = job.picture.rgba;
    const int width = job.width, height = rgba.height(), step = job.numbers.step;
    const hn::Repartition<std::uint8_t, IntTag> tag;
    RowsAround<std::uint8_t> bends(width, 1);
    std::uint8_t* bend = bends.row(0);
    std::fill_n(bend - step, width + 2 * step, std::uint8_t{0});
    const Block source = hn::Set(block_tag, std::uint8_t(PixelOrigin::source));
    Block others = hn::Zero(block_tag);
    for (int y = first; y < last; ++y) {
        const std::uint8_t* here = rgba.pixel(0, y);
        const bool rows = y >= step && y + step < height;
        const std::uint8_t* above = rows ? rgba.pixel(0, y - step) : here;
        const std::uint8_t* below = rows ? rgba.pixel(0, y + step) : here;
        std::uint8_t* contrast = job.contrast.row(y);
        const auto alone = [&](int x) {
            EdgeDifferences found;
            if (x >= step && x + step < width)
                found.widen(here + 4 * x, here + 4 * (x - step), here + 4 * (x + step));
            if (rows)
                found.widen(here + 4 * x, above + 4 * x, below + 4 * x);
            contrast[x] = found.contrast;
            bend[x] = found.bend;
        };
        int x = 0;
        for (; x < std::min(step, width); ++x)
            alone(x);
        for (; x + lanes + step <= width; x += lanes) {
            const auto h = hn::LoadU(tag, here + 4 * x);
            const auto a = hn::LoadU(tag, above + 4 * x), b = hn::LoadU(tag, below + 4 * x);
            const auto l = hn::LoadU(tag, here + 4 * (x - step)), r = hn::LoadU(tag, here + 4 * (x + step));
            const auto most =
                hn::Max(hn::Max(difference(h, a), difference(h, b)), hn::Max(difference(h, l), difference(h, r)));
            const auto bent = hn::Max(difference(h, hn::AverageRound(a, b)), difference(h, hn::AverageRound(l, r)));
            hn::StoreU(worst_channel(most), byte_tag, contrast + x);
            hn::StoreU(worst_channel(bent), byte_tag, bend + x);
        }
        for (; x < width; ++x)
            alone(x);
        std::uint8_t* along = job.along.row(y);
        const std::uint8_t* origin = job.picture.origin.pixel(0, y);
        over_blocks(width, [&](int at) HWY_ATTR {
            hn::StoreU(
                hn::Max(load_block(bend + at), hn::Max(load_block(bend + at - step), load_block(bend + at + step))),
                block_tag, along + at);
            others = hn::Or(others, hn::Xor(load_block(origin + at), source));
        });
    }
    return !hn::AllTrue(block_tag, others == hn::Zero(block_tag));
}

void fill_columns_here(const MapJob& job, int first, int last) {
    const ByteImage& origin = job.picture.origin;
    const int height = origin.height();
    std::vector<std::uint8_t> column(std::size_t(last - first), 255);
    std::uint8_t* c = column.data();
    for (int y = 0; y < height; ++y) {
        const std::uint8_t* o = origin.pixel(0, y) + first;
        std::uint8_t* to = job.filled.row(y) + first;
        for (int x = 0; x < last - first; ++x) {
            const auto more = std::uint8_t(std::min<std::uint8_t>(c[x], 254) + 1);
            c[x] = to[x] = o[x] == std::uint8_t(PixelOrigin::source) ? std::uint8_t(0) : more;
        }
    }
    std::ranges::fill(column, std::uint8_t{255});
    for (int y = height - 1; y >= 0; --y) {
        std::uint8_t* to = job.filled.row(y) + first;
        for (int x = 0; x < last - first; ++x) {
            const auto more = std::uint8_t(std::min<std::uint8_t>(c[x], 254) + 1);
            c[x] = to[x] = std::min(to[x], more);
        }
    }
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
