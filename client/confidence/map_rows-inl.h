// Rows that the map's loops are made of (inverse depth, silhouettes, texture), and planes of a whole picture that they
// are judged by: differences to what is beside a pixel, steps along columns. Included once for each instruction set.
#if defined(EQUISTREAM_MAP_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_MAP_ROWS_INL_H
#undef EQUISTREAM_MAP_ROWS_INL_H
#else
#define EQUISTREAM_MAP_ROWS_INL_H
#endif

#include "map_kernels.h"

#include <client/warp/warp_positions-inl.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

using ByteTag = hn::Rebind<std::uint8_t, FloatTag>;
constexpr ByteTag byte_tag;

HWY_INLINE Floats bytes_as_floats(const std::uint8_t* from) {
    return hn::ConvertTo(float_tag, hn::PromoteTo(int_tag, hn::LoadU(byte_tag, from)));
}

/// Rows around those of a band, each with a margin on either side that repeats its ends.
template <typename Sample>
class RowsAround {
public:
    RowsAround(int width, int rows)
        : stride_(width + 2 * margin),
          samples_(std::make_unique_for_overwrite<Sample[]>(std::size_t(stride_) * std::size_t(rows))) {}
    Sample* row(int index) { return samples_.get() + std::ptrdiff_t(index) * stride_ + margin; }
    const Sample* row(int index) const { return samples_.get() + std::ptrdiff_t(index) * stride_ + margin; }
    void repeat_ends(int index, int width) {
        std::fill_n(row(index) - margin, margin, row(index)[0]);
        std::fill_n(row(index) + width, margin, row(index)[width - 1]);
    }

private:
    static constexpr int margin = min_map_width + 16;
    int stride_;
    std::unique_ptr<Sample[]> samples_;
};

/// Calls `at(x)` for vectors of pixels that together cover a row; the last may overlap the one before, or reach beyond
/// a row that is shorter than a vector.
template <typename At>
HWY_INLINE void over_row(int width, const At& at) {
    for (int x = 0; x < width; x += lanes)
        at(std::max(0, std::min(x, width - lanes)));
}

/// Bytes by the block, for loops whose pointers a compiler cannot tell apart.
using BlockTag = hn::CappedTag<std::uint8_t, min_map_width>;
using Block = hn::Vec<BlockTag>;
constexpr BlockTag block_tag;

HWY_INLINE Block load_block(const std::uint8_t* from) {
    return hn::LoadU(block_tag, from);
}

/// As over_row, in blocks of bytes.
template <typename At>
HWY_INLINE void over_blocks(int count, const At& at) {
    constexpr int block = int(hn::MaxLanes(BlockTag()));
    for (int x = 0; x < count; x += block)
        at(std::max(0, std::min(x, count - block)));
}

/// 1 / planar depth of a row; 0 for a miss and where there is no depth.
HWY_INLINE void inverse_planar_row(const RiskNumbers& n, int y, float* to) {
    const int width = n.depth_m.width;
    const float inverse_focal = 1 / n.focal_px;
    const float b = (float(y) + 0.5f - 0.5f * float(n.depth_m.height)) * inverse_focal;
    const float* from = n.depth_m.row(y);
    over_row(width, [&](int x) HWY_ATTR {
        const Floats a = (columns_from(x) + all(0.5f - 0.5f * float(width))) * all(inverse_focal);
        const Floats depth = hn::LoadU(float_tag, from + x);
        const Floats length2 = hn::MulAdd(a, a, all(1 + b * b));
        const Floats inverse = length2 * formulas::over_sqrt(length2).lanes / depth;
        hn::StoreU(hn::IfThenElseZero(depth > all(0.0f), hn::Min(inverse, all(max_inverse_m))), float_tag, to + x);
    });
}

/// 1 or 0 as bytes.
HWY_INLINE void store_marks(FloatMask mask, std::uint8_t* to) {
    const Ints ones = hn::IfThenElseZero(hn::RebindMask(int_tag, mask), all(1));
    hn::StoreU(hn::U8FromU32(hn::BitCast(hn::RebindToUnsigned<IntTag>(), ones)), byte_tag, to);
}

/// Silhouettes and borders between origins of a band: closeness 3 to 0 of plain_engines.h.
class ClosenessRows {
public:
    /// Of `rows` rows.
    ClosenessRows(int width, int rows)
        : width_(width), marks_(width, rows + 2 * reach), near_(width, 1), nearer_(width, 1) {}

    /// `planar(y)` gives inverse planar depth of rows up to four beyond the band, rows outside the picture as the
    /// nearest inside; not called without depth.
    template <typename Planar>
    HWY_INLINE void mark(const MapJob& job, int first, int last, const Planar& planar) {
        const int height = job.picture.origin.height();
        first_ = first;
        for (int y = first - reach; y < last + reach; ++y) {
            std::uint8_t* marks = marks_.row(y - first + reach);
            if (y < 0 || y >= height) {
                std::fill_n(marks - 2, width_ + 4, std::uint8_t{0});
                continue;
            }
            mark_origins(job.picture.origin, y, marks);
            if (job.numbers.has_depth())
                mark_steps(job.numbers, y, planar, marks);
            marks[-1] = marks[-2] = marks[width_] = marks[width_ + 1] = 0;
        }
    }

    HWY_INLINE void closeness(int y, std::uint8_t* out) {
        const int at = y - first_ + reach;
        const std::uint8_t *a = marks_.row(at - 2), *b = marks_.row(at - 1), *c = marks_.row(at),
                           *d = marks_.row(at + 1), *e = marks_.row(at + 2);
        std::uint8_t *near = near_.row(0), *nearer = nearer_.row(0);
        over_blocks(width_ + 2 * reach, [&](int i) HWY_ATTR {
            const int x = i - reach;
            const Block three = hn::Or(load_block(b + x), hn::Or(load_block(c + x), load_block(d + x)));
            hn::StoreU(three, block_tag, nearer + x);
            hn::StoreU(hn::Or(three, hn::Or(load_block(a + x), load_block(e + x))), block_tag, near + x);
        });
        over_blocks(width_, [&](int x) HWY_ATTR {
            const Block two =
                hn::Or(hn::Or(load_block(near + x - 2), load_block(near + x - 1)),
                       hn::Or(load_block(near + x), hn::Or(load_block(near + x + 1), load_block(near + x + 2))));
            const Block one =
                hn::Or(load_block(nearer + x - 1), hn::Or(load_block(nearer + x), load_block(nearer + x + 1)));
            hn::StoreU(two + one + load_block(c + x), block_tag, out + x);
        });
    }

private:
    static constexpr int reach = 2;

    HWY_INLINE void mark_origins(const ByteImage& origin, int y, std::uint8_t* marks) const {
        const std::uint8_t* here = origin.pixel(0, y);
        const std::uint8_t* above = origin.pixel(0, std::max(0, y - 1));
        const std::uint8_t* below = origin.pixel(0, std::min(origin.height() - 1, y + 1));
        over_blocks(width_ - 2, [&](int i) HWY_ATTR {
            const int x = i + 1;
            const Block o = load_block(here + x);
            const Block differs =
                hn::Or(hn::Or(hn::Xor(o, load_block(here + x - 1)), hn::Xor(o, load_block(here + x + 1))),
                       hn::Or(hn::Xor(o, load_block(above + x)), hn::Xor(o, load_block(below + x))));
            hn::StoreU(hn::Min(differs, hn::Set(block_tag, 1)), block_tag, marks + x);
        });
        for (const int x : {0, width_ - 1}) {
            const int before = std::max(0, x - 1), after = std::min(width_ - 1, x + 1);
            marks[x] = here[x] != here[before] || here[x] != here[after] || here[x] != above[x] || here[x] != below[x];
        }
    }

    template <typename Planar>
    HWY_INLINE void mark_steps(const RiskNumbers& n, int y, const Planar& planar, std::uint8_t* marks) {
        const float *two_above = planar(y - 2), *above = planar(y - 1), *here = planar(y), *below = planar(y + 1),
                    *two_below = planar(y + 2);
        const float least = n.min_step_inverse_m;
        over_row(width_, [&](int x) HWY_ATTR {
            const Floats p = hn::LoadU(float_tag, here + x - 2), q = hn::LoadU(float_tag, here + x - 1),
                         r = hn::LoadU(float_tag, here + x), s = hn::LoadU(float_tag, here + x + 1),
                         t = hn::LoadU(float_tag, here + x + 2);
            const Floats a = hn::LoadU(float_tag, two_above + x), b = hn::LoadU(float_tag, above + x),
                         d = hn::LoadU(float_tag, below + x), e = hn::LoadU(float_tag, two_below + x);
            const FloatMask across = hn::Or(formulas::is_step(p, q, r, s, least), formulas::is_step(q, r, s, t, least));
            const FloatMask down = hn::Or(formulas::is_step(a, b, r, d, least), formulas::is_step(b, r, d, e, least));
            alignas(64) std::uint8_t found[lanes];
            store_marks(hn::Or(across, down), found);
            for (int i = 0; i < lanes; ++i)
                marks[x + i] = std::uint8_t(marks[x + i] | found[i]);
        });
    }

    int width_, first_ = 0;
    RowsAround<std::uint8_t> marks_, near_, nearer_;
};

/// Means of contrast over squares, by sums of columns that move down with the rows.
class TextureRows {
public:
    TextureRows(const MapJob& job, int first)
        : contrast_(job.contrast), reach_(job.numbers.texture_reach), columns_(std::size_t(job.contrast.width), 0),
          before_(std::size_t(job.contrast.width + 2 * reach_) + 2, 0),
          over_count_(std::size_t(job.contrast.width), 0.0f) {
        // One row more above: the first step takes it away again.
        for (int y = std::max(0, first - reach_ - 1); y < std::min(contrast_.height, first + reach_); ++y)
            add(y);
        next_ = first;
    }

    /// Of one row after the other, from the first on.
    HWY_INLINE void next(float* out) {
        const int width = contrast_.width;
        if (next_ + reach_ < contrast_.height)
            add(next_ + reach_);
        if (next_ - reach_ - 1 >= 0)
            take(next_ - reach_ - 1);
        const int rows = std::min(contrast_.height, next_ + reach_ + 1) - std::max(0, next_ - reach_);
        if (rows != rows_)
            count(rows);
        // before_[i]: sum of the columns before i - reach.
        std::uint32_t sum = 0;
        std::uint32_t* before = before_.data() + reach_;
        for (int x = 0; x < width; ++x) {
            before[x] = sum;
            sum += columns_[std::size_t(x)];
        }
        std::fill(before + width, before + width + reach_ + 2, sum);
        for (int x = 0; x < width; ++x)
            out[x] = float(std::int32_t(before[x + reach_ + 1] - before[x - reach_])) * over_count_[std::size_t(x)];
        ++next_;
    }

private:
    void add(int y) {
        const std::uint8_t* row = contrast_.row(y);
        for (std::size_t x = 0; x < columns_.size(); ++x)
            columns_[x] = std::uint16_t(columns_[x] + row[x]);
    }
    void take(int y) {
        const std::uint8_t* row = contrast_.row(y);
        for (std::size_t x = 0; x < columns_.size(); ++x)
            columns_[x] = std::uint16_t(columns_[x] - row[x]);
    }
    void count(int rows) {
        const int width = contrast_.width;
        rows_ = rows;
        for (int x = 0; x < width; ++x)
            over_count_[std::size_t(x)] = 1 / float((std::min(width, x + reach_ + 1) - std::max(0, x - reach_)) * rows);
    }

    ImageView<const std::uint8_t> contrast_;
    int reach_, next_ = 0, rows_ = 0;
    std::vector<std::uint16_t> columns_;
    std::vector<std::uint32_t> before_;
    std::vector<float> over_count_;
};

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
