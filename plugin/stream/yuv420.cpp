#include <equistream/yuv.h>

#include <plugin/formulas/also_for_avx2.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

namespace equistream {

namespace {

using namespace bt709;

using yuv_to_rgb::fixed;
using yuv_to_rgb::fraction_bits;

/// Going down, chroma sums have eight taps.
constexpr int chroma_bits = fraction_bits + 3;
constexpr int rows_per_block = 32;

std::uint8_t to_byte(int value) {
    return static_cast<std::uint8_t>(std::clamp(value, 0, 255));
}

EQUISTREAM_ALSO_FOR_AVX2
void luma_row(const std::uint8_t* rgb, int width, std::uint8_t* luma) {
    constexpr int red = fixed(luma_scale * kr), green = fixed(luma_scale * kg), blue = fixed(luma_scale * kb);
    constexpr int offset = fixed(16.5);
    for (int x = 0; x < width; ++x)
        luma[x] = static_cast<std::uint8_t>(
            (red * rgb[3 * x] + green * rgb[3 * x + 1] + blue * rgb[3 * x + 2] + offset) >> fraction_bits);
}

/// Per half-column the sum of eight samples of each channel, into `sums` (three per half-column).
EQUISTREAM_ALSO_FOR_AVX2
void chroma_sums(const std::uint8_t* upper, const std::uint8_t* lower, int width, int* sums) {
    for (int i = 0; 2 * i < width; ++i) {
        const int before = 3 * std::max(2 * i - 1, 0), at = 6 * i, after = at + 3;
        for (int c = 0; c < 3; ++c)
            sums[3 * i + c] = upper[before + c] + lower[before + c] + 2 * (upper[at + c] + lower[at + c]) +
                              upper[after + c] + lower[after + c];
    }
}

EQUISTREAM_ALSO_FOR_AVX2
void chroma_row(const int* sums, int half_width, std::uint8_t* cb, std::uint8_t* cr) {
    constexpr double to_cb = chroma_scale / cb_divisor, to_cr = chroma_scale / cr_divisor;
    constexpr int offset = (128 << chroma_bits) + (1 << (chroma_bits - 1));
    for (int i = 0; i < half_width; ++i) {
        const int r = sums[3 * i], g = sums[3 * i + 1], b = sums[3 * i + 2];
        cb[i] = to_byte((fixed(-kr * to_cb) * r + fixed(-kg * to_cb) * g + fixed((1 - kb) * to_cb) * b + offset) >>
                        chroma_bits);
        cr[i] = to_byte((fixed((1 - kr) * to_cr) * r + fixed(-kg * to_cr) * g + fixed(-kb * to_cr) * b + offset) >>
                        chroma_bits);
    }
}

/// chroma_eighths of a whole row.
EQUISTREAM_ALSO_FOR_AVX2
void upsampled_chroma(const ImageView<const std::uint8_t>& plane, int y, int* row) {
    const std::uint8_t* near_row = plane.row(y / 2);
    const std::uint8_t* far_row = plane.row(yuv_to_rgb::farther_row(y, plane.height));
    const auto quarters = [&](int i) { return 3 * near_row[i] + far_row[i] - 4 * 128; };
    const int last = plane.width - 1;
    for (int i = 0; i < last; ++i) {
        row[2 * i] = 2 * quarters(i);
        row[2 * i + 1] = quarters(i) + quarters(i + 1);
    }
    row[2 * last] = row[2 * last + 1] = 2 * quarters(last);
}

EQUISTREAM_ALSO_FOR_AVX2
void rgb_row(const std::uint8_t* luma, const int* cb, const int* cr, int width, std::uint8_t* rgb) {
    for (int x = 0; x < width; ++x) {
        const yuv_to_rgb::Rgb sample = yuv_to_rgb::rgb_of(luma[x], cb[x], cr[x]);
        for (int c = 0; c < 3; ++c)
            rgb[3 * x + c] = sample[static_cast<std::size_t>(c)];
    }
}

EQUISTREAM_ALSO_FOR_AVX2
void rgba_row(const std::uint8_t* luma, const int* cb, const int* cr, int width, std::uint8_t* rgba) {
    for (int x = 0; x < width; ++x) {
        const yuv_to_rgb::Rgb sample = yuv_to_rgb::rgb_of(luma[x], cb[x], cr[x]);
        for (int c = 0; c < 3; ++c)
            rgba[4 * x + c] = sample[static_cast<std::size_t>(c)];
        rgba[4 * x + 3] = 255;
    }
}

}  // namespace

void rgb_to_yuv420(ImageView<const std::uint8_t> rgb, const Yuv420View<std::uint8_t>& yuv) {
    assert(rgb.width % 2 == 0 && rgb.height % 2 == 0 && rgb.channels == 3);
    tbb::parallel_for(tbb::blocked_range<int>(0, rgb.height / 2, rows_per_block / 2), [&](const auto& pairs) {
        std::vector<int> sums(static_cast<std::size_t>(rgb.width / 2) * 3);
        for (int j = pairs.begin(); j < pairs.end(); ++j) {
            luma_row(rgb.row(2 * j), rgb.width, yuv.y.row(2 * j));
            luma_row(rgb.row(2 * j + 1), rgb.width, yuv.y.row(2 * j + 1));
            chroma_sums(rgb.row(2 * j), rgb.row(2 * j + 1), rgb.width, sums.data());
            chroma_row(sums.data(), rgb.width / 2, yuv.cb.row(j), yuv.cr.row(j));
        }
    });
}

void yuv420_to_rgb(const YuvView& yuv, ImageView<std::uint8_t> rgb) {
    assert(rgb.width % 2 == 0 && rgb.height % 2 == 0 && (rgb.channels == 3 || rgb.channels == 4));
    const auto row = rgb.channels == 4 ? rgba_row : rgb_row;
    tbb::parallel_for(tbb::blocked_range<int>(0, rgb.height, rows_per_block), [&](const auto& rows) {
        std::vector<int> cb(static_cast<std::size_t>(rgb.width)), cr(static_cast<std::size_t>(rgb.width));
        for (int y = rows.begin(); y < rows.end(); ++y) {
            upsampled_chroma(yuv.cb, y, cb.data());
            upsampled_chroma(yuv.cr, y, cr.data());
            row(yuv.y.row(y), cb.data(), cr.data(), rgb.width, rgb.row(y));
        }
    });
}

}  // namespace equistream
