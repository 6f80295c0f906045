#include "plain_pixels.h"

#include <equistream/bound.h>
#include <equistream/depth_code.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace equistream {

namespace {

using depth_rows::Scale;

constexpr std::string_view names[] = {"pece444", "pece420", "hue", "w8", "w10", "w12", "lossless"};
constexpr int rows_per_block = 32;

const depth_rows::Rows& rows() {
    static const depth_rows::Rows simd = depth_rows::simd_rows();
    return simd;
}

std::span<const float> row_of(ImageView<const float> image, int y) {
    return {image.row(y), static_cast<std::size_t>(image.width)};
}
std::span<float> row_of(ImageView<float> image, int y) {
    return {image.row(y), static_cast<std::size_t>(image.width)};
}

/// Calls `row(y)` for each row and adds up what it returns.
template <typename Row>
std::int64_t sum_over_rows(int height, const Row& row) {
    std::atomic<std::int64_t> sum = 0;
    tbb::parallel_for(tbb::blocked_range<int>(0, height, rows_per_block), [&](const auto& range) {
        std::int64_t count = 0;
        for (int y = range.begin(); y < range.end(); ++y)
            count += row(y);
        sum += count;
    });
    return sum;
}

template <typename Row>
void for_each_row(int height, const Row& row) {
    tbb::parallel_for(tbb::blocked_range<int>(0, height, rows_per_block), [&](const auto& range) {
        for (int y = range.begin(); y < range.end(); ++y)
            row(y);
    });
}

template <typename T>
std::array<T*, 3> rows_at(const std::array<ImageView<T>, 3>& planes, int y) {
    return {planes[0].row(y), planes[1].row(y), planes[2].row(y)};
}

class WCode : public DepthCode {
public:
    explicit WCode(DepthCodeId id, int bits) : id_(id), bits_(bits) {}

    DepthCodeId id() const override { return id_; }
    PlaneFormat format() const override { return {PlaneLayout::gray, bits_}; }
    int levels(const DepthRange& range) const override { return static_cast<int>(Scale(range, full()).top); }

    std::int64_t pack(ImageView<const float> depth_m, const DepthRange& range,
                      const PlanesView& planes) const override {
        const Scale scale(range, full());
        return sum_over_rows(depth_m.height, [&](int y) {
            return bits_ == 8 ? rows().pack_w8(row_of(depth_m, y), scale, planes.bytes[0].row(y))
                              : rows().pack_w16(row_of(depth_m, y), scale, planes.words[0].row(y));
        });
    }

    void unpack(const ConstPlanesView& planes, const DepthRange& range, ImageView<float> depth_m) const override {
        const Scale scale(range, full());
        for_each_row(depth_m.height, [&](int y) {
            if (bits_ == 8)
                rows().unpack_w8(planes.bytes[0].row(y), scale, row_of(depth_m, y));
            else
                rows().unpack_w16(planes.words[0].row(y), scale, row_of(depth_m, y));
        });
    }

private:
    int full() const { return (1 << bits_) - 1; }

    DepthCodeId id_;
    int bits_;
};

/// Steps of d that rounding to a whole one may change, and rounding the wave to one of 255 values over half a period.
constexpr double pece_rounding = 0.5, wave_rounding = 0.5 * depth_rows::pece_half_period / 255;

int pece_levels(const DepthRange& range) {
    return static_cast<int>(Scale(range, depth_rows::pece_full).top / (2 * (pece_rounding + wave_rounding)));
}

/// Three planes of bytes of the picture's size: pece444 or hue.
class ThreeBytes : public DepthCode {
public:
    explicit ThreeBytes(DepthCodeId id) : id_(id), is_hue_(id == DepthCodeId::hue) {}

    DepthCodeId id() const override { return id_; }
    PlaneFormat format() const override { return {is_hue_ ? PlaneLayout::gbr : PlaneLayout::yuv444, 8}; }
    int levels(const DepthRange& range) const override { return is_hue_ ? depth_rows::hue_full : pece_levels(range); }

    std::int64_t pack(ImageView<const float> depth_m, const DepthRange& range,
                      const PlanesView& planes) const override {
        const Scale scale = scale_of(range);
        const auto pack_row = is_hue_ ? rows().pack_hue : rows().pack_pece;
        return sum_over_rows(depth_m.height, [&](int y) {
            return pack_row(row_of(depth_m, y), scale, rows_at(planes.bytes, y).data());
        });
    }

    void unpack(const ConstPlanesView& planes, const DepthRange& range, ImageView<float> depth_m) const override {
        const Scale scale = scale_of(range);
        const auto unpack_row = is_hue_ ? rows().unpack_hue : rows().unpack_pece;
        for_each_row(depth_m.height,
                     [&](int y) { unpack_row(rows_at(planes.bytes, y).data(), scale, row_of(depth_m, y)); });
    }

private:
    Scale scale_of(DepthRange range) const {
        if (!is_hue_)
            return Scale(range, depth_rows::pece_full);
        // Black is kept for pixels without a surface: they take no hues away.
        const bool has_empty = std::exchange(range.has_empty, false);
        Scale scale(range, depth_rows::hue_full);
        scale.has_empty = has_empty;
        return scale;
    }

    DepthCodeId id_;
    bool is_hue_;
};

class Pece420 : public DepthCode {
public:
    DepthCodeId id() const override { return DepthCodeId::pece420; }
    PlaneFormat format() const override { return {PlaneLayout::yuv420, 8}; }
    int levels(const DepthRange& range) const override { return pece_levels(range); }

    /// Of the wave that four pixels share one pixel's own is a quarter; the others' may lie half a period away. The
    /// pixel's own rounding counts a quarter too, and the mean is rounded once more.
    double max_error(const DepthRange& range) const override {
        constexpr double steps = 0.75 * depth_rows::pece_half_period + pece_rounding + 1.25 * wave_rounding;
        return steps / double(Scale(range, depth_rows::pece_full).top);
    }

    std::int64_t pack(ImageView<const float> depth_m, const DepthRange& range,
                      const PlanesView& planes) const override {
        const Scale scale(range, depth_rows::pece_full);
        return sum_over_rows(depth_m.height / 2, [&](int j) {
            const int upper = 2 * j, lower = upper + 1;
            return rows().pack_pece420({row_of(depth_m, upper),
                                        row_of(depth_m, lower),
                                        {planes.bytes[0].row(upper), planes.bytes[0].row(lower)},
                                        {planes.bytes[1].row(j), planes.bytes[2].row(j)}},
                                       scale);
        });
    }

    void unpack(const ConstPlanesView& planes, const DepthRange& range, ImageView<float> depth_m) const override {
        const Scale scale(range, depth_rows::pece_full);
        for_each_row(depth_m.height, [&](int y) {
            rows().unpack_pece420(planes.bytes[0].row(y), planes.bytes[2].row(y / 2), scale, row_of(depth_m, y));
        });
    }
};

class Lossless : public DepthCode {
public:
    DepthCodeId id() const override { return DepthCodeId::lossless; }
    PlaneFormat format() const override { return {PlaneLayout::yuv444, 12}; }
    int levels(const DepthRange&) const override { return 0; }

    std::int64_t pack(ImageView<const float> depth_m, const DepthRange&, const PlanesView& planes) const override {
        const auto pack_row = rows().pack_bits;
        for_each_row(depth_m.height, [&](int y) { pack_row(row_of(depth_m, y), rows_at(planes.words, y).data()); });
        return 0;
    }

    void unpack(const ConstPlanesView& planes, const DepthRange&, ImageView<float> depth_m) const override {
        const auto unpack_row = rows().unpack_bits;
        for_each_row(depth_m.height, [&](int y) { unpack_row(rows_at(planes.words, y).data(), row_of(depth_m, y)); });
    }
};

}  // namespace

double DepthCode::max_error(const DepthRange& range) const {
    const int steps = levels(range);
    return steps == 0 ? 0 : 0.5 / steps;
}

const char* depth_code_name(DepthCodeId code) {
    return names[static_cast<std::size_t>(code)].data();
}

std::span<const std::string_view> depth_code_names() {
    return names;
}

std::unique_ptr<DepthCode> make_depth_code(DepthCodeId code) {
    switch (code) {
    case DepthCodeId::pece444:
    case DepthCodeId::hue:
        return std::make_unique<ThreeBytes>(code);
    case DepthCodeId::pece420:
        return std::make_unique<Pece420>();
    case DepthCodeId::w8:
        return std::make_unique<WCode>(code, 8);
    case DepthCodeId::w10:
        return std::make_unique<WCode>(code, 10);
    case DepthCodeId::w12:
        return std::make_unique<WCode>(code, 12);
    case DepthCodeId::lossless:
        break;
    }
    return std::make_unique<Lossless>();
}

std::unique_ptr<DepthCode> make_depth_code(std::string_view name) {
    const auto found = std::ranges::find(names, name);
    if (found == std::end(names))
        // Not "'" + ...: at -O3 GCC 12 takes that for a copy onto itself (its bug 105651) and warns.
        throw InputError(
            expected_found("depth code", "one of " + in_a_sentence(names, ", "), std::string("'").append(name) + "'"));
    return make_depth_code(static_cast<DepthCodeId>(found - std::begin(names)));
}

}  // namespace equistream
