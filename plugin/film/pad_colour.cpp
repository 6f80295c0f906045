#include "pad_colour.h"

#include <algorithm>
#include <vector>

namespace equistream {
namespace {

/// One size of the picture: colour, and where there is some.
struct Level {
    FloatImage rgb;
    ByteImage known;
};

/// Half as wide and high, rounded up: the mean of what is known of each block.
Level halved(const Level& fine) {
    const int width = fine.rgb.width(), height = fine.rgb.height();
    Level coarse{FloatImage((width + 1) / 2, (height + 1) / 2, 3), ByteImage((width + 1) / 2, (height + 1) / 2, 1)};
    for (int y = 0; y < coarse.rgb.height(); ++y)
        for (int x = 0; x < coarse.rgb.width(); ++x) {
            float* const mean = coarse.rgb.pixel(x, y);
            int count = 0;
            for (int from_y = 2 * y; from_y < std::min(2 * y + 2, height); ++from_y)
                for (int from_x = 2 * x; from_x < std::min(2 * x + 2, width); ++from_x) {
                    if (*fine.known.pixel(from_x, from_y) == 0)
                        continue;
                    ++count;
                    for (int c = 0; c < 3; ++c)
                        mean[c] += fine.rgb.pixel(from_x, from_y)[c];
                }
            for (int c = 0; c < 3 && count > 0; ++c)
                mean[c] /= static_cast<float>(count);
            *coarse.known.pixel(x, y) = count > 0;
        }
    return coarse;
}

/// Of the coarser level, all of it known, at pixel i of the finer one: between the two nearest of its pixels.
struct Blend {
    int near, far;

    Blend(int i, int coarse_size, bool closes) : near(i / 2), far(near + (i % 2 == 0 ? -1 : 1)) {
        far = closes ? (far + coarse_size) % coarse_size : std::clamp(far, 0, coarse_size - 1);
    }
};

void fill_from(const Level& coarse, Level& fine, bool closes) {
    for (int y = 0; y < fine.rgb.height(); ++y) {
        const Blend rows(y, coarse.rgb.height(), false);
        for (int x = 0; x < fine.rgb.width(); ++x) {
            if (*fine.known.pixel(x, y) != 0)
                continue;
            const Blend columns(x, coarse.rgb.width(), closes);
            const float *a = coarse.rgb.pixel(columns.near, rows.near), *b = coarse.rgb.pixel(columns.far, rows.near);
            const float *c = coarse.rgb.pixel(columns.near, rows.far), *d = coarse.rgb.pixel(columns.far, rows.far);
            for (int k = 0; k < 3; ++k)
                fine.rgb.pixel(x, y)[k] = 0.5625f * a[k] + 0.1875f * (b[k] + c[k]) + 0.0625f * d[k];
        }
    }
}

}  // namespace

void pad_colour(FloatImage& rgba, const ByteImage& known, bool closes) {
    std::vector<Level> levels{{FloatImage(rgba.width(), rgba.height(), 3), known}};
    for (int y = 0; y < rgba.height(); ++y)
        for (int x = 0; x < rgba.width(); ++x)
            std::copy(rgba.pixel(x, y), rgba.pixel(x, y) + 3, levels[0].rgb.pixel(x, y));
    while (levels.back().rgb.width() > 1 || levels.back().rgb.height() > 1)
        levels.push_back(halved(levels.back()));
    for (std::size_t level = levels.size() - 1; level-- > 0;)
        fill_from(levels[level + 1], levels[level], closes);
    for (int y = 0; y < rgba.height(); ++y)
        for (int x = 0; x < rgba.width(); ++x) {
            if (*known.pixel(x, y) != 0)
                continue;
            std::copy(levels[0].rgb.pixel(x, y), levels[0].rgb.pixel(x, y) + 3, rgba.pixel(x, y));
            rgba.pixel(x, y)[3] = 0;
        }
}

}  // namespace equistream
