#include <equistream/yuv.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace equistream {

namespace {

using namespace bt2020;

constexpr int rows_per_block = 32;

std::uint16_t to_sample(double value) {
    return static_cast<std::uint16_t>(std::clamp(std::lround(value), 0L, 1023L));
}

/// Chroma from its middle, in eighths of a sample, at column x and row y of luma.
float chroma_eighths(const ImageView<const std::uint16_t>& plane, int x, int y) {
    const std::uint16_t* near_row = plane.row(y / 2);
    const std::uint16_t* far_row = plane.row(yuv_to_rgb::farther_row(y, plane.height));
    const int left = x / 2, right = std::min((x + 1) / 2, plane.width - 1);
    return float(3 * (near_row[left] + near_row[right]) + far_row[left] + far_row[right] - 8 * int(chroma_middle));
}

}  // namespace

FloatImage pq_to_rgb(const PqView& planes) {
    FloatImage rgb(planes.y.width, planes.y.height, 3);
    constexpr auto chroma = float(1 / (8 * chroma_scale));
    tbb::parallel_for(tbb::blocked_range<int>(0, rgb.height(), rows_per_block), [&](const auto& rows) {
        for (int y = rows.begin(); y < rows.end(); ++y)
            for (int x = 0; x < rgb.width(); ++x) {
                const float luma = (float(planes.y.row(y)[x]) - float(luma_black)) * float(1 / luma_scale);
                const float cb = chroma * chroma_eighths(planes.cb, x, y),
                            cr = chroma * chroma_eighths(planes.cr, x, y);
                float* to = rgb.pixel(x, y);
                to[0] = std::clamp(luma + float(cr_divisor) * cr, 0.0f, 1.0f);
                to[1] = std::clamp(luma + float(green_from_cb) * cb + float(green_from_cr) * cr, 0.0f, 1.0f);
                to[2] = std::clamp(luma + float(cb_divisor) * cb, 0.0f, 1.0f);
            }
    });
    return rgb;
}

void rgb_to_pq(ImageView<const float> rgb, const Yuv420View<std::uint16_t>& planes) {
    assert(rgb.width % 2 == 0 && rgb.height % 2 == 0 && rgb.channels == 3);
    const auto luma_of = [](const double* c) { return kr * c[0] + kg * c[1] + kb * c[2]; };
    tbb::parallel_for(tbb::blocked_range<int>(0, rgb.height / 2, rows_per_block / 2), [&](const auto& pairs) {
        for (int j = pairs.begin(); j < pairs.end(); ++j)
            for (int i = 0; i < rgb.width / 2; ++i) {
                double mean[3] = {};
                for (const int y : {2 * j, 2 * j + 1}) {
                    for (const int step : {-1, 0, 1}) {
                        const float* at = rgb.row(y) + 3 * std::max(2 * i + step, 0);
                        for (int c = 0; c < 3; ++c)
                            mean[c] += (step == 0 ? 0.25 : 0.125) * double(at[c]);
                    }
                    for (const int x : {2 * i, 2 * i + 1}) {
                        const float* at = rgb.row(y) + 3 * x;
                        const double colour[3] = {at[0], at[1], at[2]};
                        planes.y.row(y)[x] = to_sample(luma_black + luma_scale * luma_of(colour));
                    }
                }
                const double luma = luma_of(mean);
                planes.cb.row(j)[i] = to_sample(chroma_middle + chroma_scale * (mean[2] - luma) / cb_divisor);
                planes.cr.row(j)[i] = to_sample(chroma_middle + chroma_scale * (mean[0] - luma) / cr_divisor);
            }
    });
}

}  // namespace equistream
