#include "layer_extension.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace equistream {

namespace {

/// The mean of each 2x2 that are there; there where any is.
FloatImage halved(const FloatImage& samples, const ByteImage& there, ByteImage& half_there) {
    const int width = (samples.width() + 1) / 2, height = (samples.height() + 1) / 2, channels = samples.channels();
    FloatImage half(width, height, channels);
    half_there = ByteImage(width, height, 1);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            float* sum = half.pixel(x, y);
            std::fill_n(sum, channels, 0.0f);
            int count = 0;
            for (int v = 2 * y; v < std::min(2 * y + 2, samples.height()); ++v)
                for (int u = 2 * x; u < std::min(2 * x + 2, samples.width()); ++u) {
                    if (*there.pixel(u, v) == 0)
                        continue;
                    ++count;
                    for (int c = 0; c < channels; ++c)
                        sum[c] += samples.pixel(u, v)[c];
                }
            *half_there.pixel(x, y) = count > 0;
            for (int c = 0; c < channels && count > 0; ++c)
                sum[c] /= float(count);
        }
    return half;
}

void extend_level(FloatImage& samples, const ByteImage& there) {
    if (std::ranges::count(there.samples(), 0) == 0)
        return;
    ByteImage half_there;
    FloatImage half = halved(samples, there, half_there);
    extend_level(half, half_there);
    const int channels = samples.channels();
    for (int y = 0; y < samples.height(); ++y)
        for (int x = 0; x < samples.width(); ++x) {
            if (*there.pixel(x, y) != 0)
                continue;
            // Bilinear: the coarser sample that holds the place lies nearer (3/4) than the one beside it (1/4).
            const std::array<int, 2> columns = {x / 2, std::clamp(x / 2 + (x % 2 != 0 ? 1 : -1), 0, half.width() - 1)};
            const std::array<int, 2> rows = {y / 2, std::clamp(y / 2 + (y % 2 != 0 ? 1 : -1), 0, half.height() - 1)};
            for (int c = 0; c < channels; ++c)
                samples.pixel(x, y)[c] =
                    0.75f * (0.75f * half.pixel(columns[0], rows[0])[c] + 0.25f * half.pixel(columns[1], rows[0])[c]) +
                    0.25f * (0.75f * half.pixel(columns[0], rows[1])[c] + 0.25f * half.pixel(columns[1], rows[1])[c]);
        }
}

ByteImage where_there(ImageView<const float> depth_m) {
    ByteImage there(depth_m.width, depth_m.height, 1);
    for (int y = 0; y < depth_m.height; ++y)
        std::transform(depth_m.row(y), depth_m.row(y) + depth_m.width, there.pixel(0, y),
                       [](float r) { return std::uint8_t(!std::isnan(r)); });
    return there;
}

}  // namespace

void extend(FloatImage& samples, ImageView<const std::uint8_t> there) {
    assert(there.width == samples.width() && there.height == samples.height());
    ByteImage present(there.width, there.height, 1);
    for (int y = 0; y < there.height; ++y)
        std::copy_n(there.row(y), there.width, present.pixel(0, y));
    if (std::ranges::count(present.samples(), 0) != std::ptrdiff_t(present.samples().size()))
        extend_level(samples, present);
}

void extend_depth(FloatImage& depth_m, double box_radius_m) {
    const ByteImage there = where_there(depth_m.view());
    if (std::ranges::count(there.samples(), 0) == std::ptrdiff_t(there.samples().size()))
        return;
    const float box = float(box_radius_m);
    // On and inside the box w has no value; what lies there is far beyond any code's nearest depth and stays so.
    constexpr float largest_w = 1e6f;
    FloatImage w(depth_m.width(), depth_m.height(), 1);
    std::ranges::transform(depth_m.samples(), w.samples().begin(),
                           [&](float r) { return r > box ? std::min(box / (r - box), largest_w) : largest_w; });
    extend(w, there.view());
    for (std::size_t i = 0; i < w.samples().size(); ++i)
        if (there.samples()[i] == 0)
            depth_m.samples()[i] =
                w.samples()[i] > 0 ? box + box / w.samples()[i] : std::numeric_limits<float>::infinity();
}

void extend_colour(ByteImage& rgb, ImageView<const float> depth_m) {
    FloatImage samples(rgb.width(), rgb.height(), rgb.channels());
    std::ranges::copy(rgb.samples(), samples.samples().begin());
    extend(samples, where_there(depth_m).view());
    std::ranges::transform(samples.samples(), rgb.samples().begin(),
                           [](float value) { return std::uint8_t(value + 0.5f); });
}

}  // namespace equistream
