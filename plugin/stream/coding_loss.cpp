#include <equistream/coding_loss.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace equistream {

namespace {

constexpr auto& textures = CodingLoss::textures;
constexpr double fewest_pixels = 100;
using Range = tbb::blocked_range<int>;

int difference(std::uint8_t a, std::uint8_t b) {
    return a > b ? a - b : b - a;
}

int worst_difference(const std::uint8_t* a, const std::uint8_t* b) {
    return std::max({difference(a[0], b[0]), difference(a[1], b[1]), difference(a[2], b[2])});
}

std::uint8_t as_byte(double share) {
    return std::uint8_t(std::lround(255 * share));
}

/// Where a texture lies: so much of the way from one of CodingLoss::textures to the next.
struct Between {
    std::size_t below = 0;
    float share = 0;
};

Between between(float texture) {
    std::size_t below = 0;
    while (below + 2 < textures.size() && texture >= textures[below + 1])
        ++below;
    const float share = (texture - textures[below]) / (textures[below + 1] - textures[below]);
    return {below, std::clamp(share, 0.0f, 1.0f)};
}

}  // namespace

ByteImage contrast_of(ImageView<const std::uint8_t> pixels, int step) {
    assert(pixels.channels >= 3 && step > 0);
    const int width = pixels.width, height = pixels.height;
    ByteImage contrast(width, height, 1);
    tbb::parallel_for(Range(0, height, 32), [&](const Range& rows) {
        for (int y = rows.begin(); y < rows.end(); ++y) {
            std::uint8_t* out = contrast.pixel(0, y);
            if (y >= step && y + step < height)
                for (int x = 0; x < width; ++x)
                    out[x] = std::uint8_t(std::max(worst_difference(pixels.pixel(x, y), pixels.pixel(x, y - step)),
                                                   worst_difference(pixels.pixel(x, y), pixels.pixel(x, y + step))));
            for (int x = step; x + step < width; ++x)
                out[x] =
                    std::uint8_t(std::max({int(out[x]), worst_difference(pixels.pixel(x, y), pixels.pixel(x - step, y)),
                                           worst_difference(pixels.pixel(x, y), pixels.pixel(x + step, y))}));
        }
    });
    return contrast;
}

FloatImage mean_around(const ByteImage& image, int reach) {
    const int width = image.width(), height = image.height();
    // Sums of all that lies above and to the left: 8 K by 8 K of the largest samples stay far below 2^64.
    const std::size_t stride = std::size_t(width) + 1;
    std::vector<std::uint64_t> sums(stride * (std::size_t(height) + 1), 0);
    for (int y = 0; y < height; ++y) {
        std::uint64_t along = 0;
        for (int x = 0; x < width; ++x) {
            along += image.pixel(x, y)[0];
            const std::size_t at = std::size_t(y + 1) * stride + std::size_t(x) + 1;
            sums[at] = sums[at - stride] + along;
        }
    }
    FloatImage means(width, height, 1);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t left = std::size_t(std::max(0, x - reach)),
                              right = std::size_t(std::min(width, x + reach + 1));
            const std::size_t top = std::size_t(std::max(0, y - reach)),
                              bottom = std::size_t(std::min(height, y + reach + 1));
            const std::uint64_t sum = sums[bottom * stride + right] + sums[top * stride + left] -
                                      sums[top * stride + right] - sums[bottom * stride + left];
            means.pixel(x, y)[0] = float(sum) / float((right - left) * (bottom - top));
        }
    return means;
}

float loss_at(const CodingLoss& loss, float texture) {
    const auto [below, share] = between(texture);
    const auto a = float(loss.share_255[below]), b = float(loss.share_255[below + 1]);
    return (a + (b - a) * share) * (1 / 255.0f);
}

CodingLoss usual_coding_loss(double crf) {
    CodingLoss loss;
    for (std::size_t i = 0; i < textures.size(); ++i) {
        // Errors grow with what there is to lose and with the quantiser, and are spread as Laplace has it.
        const double deviation_255 = 1.3 * std::exp2(0.72 * double(textures[i]) + 0.096 * (crf - 16));
        loss.share_255[i] = as_byte(std::exp(-std::sqrt(2.0) * visible_loss_255 / deviation_255));
    }
    return loss;
}

void CodingLossMeter::add(ImageView<const std::uint8_t> picture, ImageView<const std::uint8_t> decoded) {
    assert(picture.width == decoded.width && picture.height == decoded.height);
    const FloatImage contrast = mean_around(contrast_of(decoded, 1), texture_steps);
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            const auto [below, share] = between(std::log2(1 + 0.5f * contrast.pixel(x, y)[0]));
            const bool lost = worst_difference(picture.pixel(x, y), decoded.pixel(x, y)) > visible_loss_255;
            for (const auto& [at, weight] :
                 {std::pair{below, 1 - double(share)}, std::pair{below + 1, double(share)}}) {
                pixels_[at] += weight;
                lost_[at] += lost ? weight : 0;
            }
        }
}

CodingLoss CodingLossMeter::loss() const {
    CodingLoss loss;
    for (std::size_t i = 0; i < textures.size(); ++i) {
        std::optional<std::size_t> nearest;
        for (std::size_t other = 0; other < textures.size(); ++other)
            if (pixels_[other] >= fewest_pixels &&
                (!nearest || std::abs(textures[other] - textures[i]) < std::abs(textures[*nearest] - textures[i])))
                nearest = other;
        if (nearest)
            loss.share_255[i] = as_byte(lost_[*nearest] / pixels_[*nearest]);
    }
    return loss;
}

}  // namespace equistream
