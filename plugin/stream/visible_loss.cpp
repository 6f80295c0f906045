#include <equistream/visible_loss.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <optional>
#include <vector>

namespace equistream {

namespace {

constexpr auto& textures = VisibleLoss::textures;
constexpr double fewest_pixels = 100;
using Range = tbb::blocked_range<int>;

int difference(std::uint8_t a, std::uint8_t b) {
    return a > b ? a - b : b - a;
}

int worst_difference(const std::uint8_t* a, const std::uint8_t* b) {
    return std::max({difference(a[0], b[0]), difference(a[1], b[1]), difference(a[2], b[2])});
}

/// The largest difference of a channel to whichever of the two is nearer; what lies between them is not off.
int worst_beside_both(const std::uint8_t* shown, const std::uint8_t* first, const std::uint8_t* second) {
    int worst = 0;
    for (int c = 0; c < 3; ++c) {
        const int least = std::min(first[c], second[c]), most = std::max(first[c], second[c]);
        worst = std::max({worst, shown[c] - most, least - shown[c]});
    }
    return worst;
}

std::uint8_t as_byte(double share) {
    return std::uint8_t(std::lround(255 * share));
}

/// Where a texture lies: so much of the way from one of VisibleLoss::textures to the next.
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

/// Pixels by texture, shared out between the two around theirs. Whole numbers: the same in whatever order they add up,
/// so that the same pictures give the same stream.
struct Counts {
    static constexpr int one = 256;
    std::array<std::uint64_t, textures.size()> pixels{}, lost{};

    void add(const Between& at, bool is_lost) {
        const auto above = std::uint64_t(std::lround(at.share * one)), below = one - above;
        pixels[at.below] += below;
        pixels[at.below + 1] += above;
        lost[at.below] += is_lost ? below : 0;
        lost[at.below + 1] += is_lost ? above : 0;
    }
    Counts& operator+=(const Counts& other) {
        for (std::size_t i = 0; i < textures.size(); ++i) {
            pixels[i] += other.pixels[i];
            lost[i] += other.lost[i];
        }
        return *this;
    }
};

/// Of all pixels that `off_by(x, y)` says something of.
template <typename OffBy>
Counts counted(ImageView<const std::uint8_t> shown, const OffBy& off_by) {
    const FloatImage contrast = mean_around(contrast_of(shown, 1), texture_steps);
    return tbb::parallel_reduce(
        Range(0, shown.height, 32), Counts(),
        [&](const Range& rows, Counts found) {
            for (int y = rows.begin(); y < rows.end(); ++y)
                for (int x = 0; x < shown.width; ++x)
                    if (const std::optional<int> off = off_by(x, y))
                        found.add(between(std::log2(1 + 0.5f * contrast.pixel(x, y)[0])), *off > visible_loss_255);
            return found;
        },
        [](Counts a, const Counts& b) { return a += b; });
}

template <typename Sums>
void add_counts(const Counts& counts, Sums& sums) {
    for (std::size_t i = 0; i < textures.size(); ++i) {
        sums.pixels[i] += double(counts.pixels[i]) / Counts::one;
        sums.lost[i] += double(counts.lost[i]) / Counts::one;
    }
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
    IdImage along(width, height, 1);  // sums of what a row has of each square
    tbb::parallel_for(Range(0, height, 32), [&](const Range& rows) {
        std::vector<std::uint32_t> before(std::size_t(width) + 1, 0);  // sums of all to the left
        for (int y = rows.begin(); y < rows.end(); ++y) {
            std::inclusive_scan(image.pixel(0, y), image.pixel(0, y) + width, before.begin() + 1, std::plus<>(),
                                std::uint32_t{0});
            for (int x = 0; x < width; ++x)
                along.pixel(x, y)[0] =
                    before[std::size_t(std::min(width, x + reach + 1))] - before[std::size_t(std::max(0, x - reach))];
        }
    });
    FloatImage means(width, height, 1);
    tbb::parallel_for(Range(0, height, 32), [&](const Range& rows) {
        std::vector<std::uint32_t> sums(std::size_t(width), 0);
        for (int y = rows.begin(); y < rows.end(); ++y) {
            const int top = std::max(0, y - reach), bottom = std::min(height, y + reach + 1);
            std::ranges::fill(sums, 0u);
            for (int row = top; row < bottom; ++row)
                for (int x = 0; x < width; ++x)
                    sums[std::size_t(x)] += along.pixel(x, row)[0];
            for (int x = 0; x < width; ++x) {
                const int columns = std::min(width, x + reach + 1) - std::max(0, x - reach);
                means.pixel(x, y)[0] = float(sums[std::size_t(x)]) / float(columns * (bottom - top));
            }
        }
    });
    return means;
}

float loss_at(const VisibleLoss& loss, float texture) {
    const auto [below, share] = between(texture);
    const auto a = float(loss.share_255[below]), b = float(loss.share_255[below + 1]);
    return (a + (b - a) * share) * (1 / 255.0f);
}

VisibleLoss usual_coding_loss(double crf) {
    VisibleLoss loss;
    for (std::size_t i = 0; i < textures.size(); ++i) {
        // Errors grow with what there is to lose and with the quantiser, and are spread as Laplace has it.
        const double deviation_255 = 1.3 * std::exp2(0.72 * double(textures[i]) + 0.096 * (crf - 16));
        loss.share_255[i] = as_byte(std::exp(-std::sqrt(2.0) * visible_loss_255 / deviation_255));
    }
    return loss;
}

void VisibleLossMeter::add(ImageView<const std::uint8_t> picture, ImageView<const std::uint8_t> decoded) {
    assert(decoded.width == picture.width && decoded.height == picture.height);
    const auto off_by = [&](int x, int y) {
        return std::optional(worst_difference(picture.pixel(x, y), decoded.pixel(x, y)));
    };
    add_counts(counted(decoded, off_by), coded_);
}

void VisibleLossMeter::add_reference(ImageView<const std::uint8_t> shown, ImageView<const std::uint8_t> reference,
                                     ImageView<const std::uint8_t> repeat) {
    assert(shown.width == reference.width && shown.height == reference.height && reference.channels == 4);
    assert(shown.width == repeat.width && shown.height == repeat.height);
    const auto off_by = [&](int x, int y) -> std::optional<int> {
        const std::uint8_t* const known = reference.pixel(x, y);
        return known[3] == 0 ? std::nullopt
                             : std::optional(worst_beside_both(shown.pixel(x, y), known, repeat.pixel(x, y)));
    };
    add_counts(counted(shown, off_by), referred_);
}

VisibleLoss VisibleLossMeter::loss() const {
    const VisibleLoss coded = coded_.loss().value_or(VisibleLoss());
    VisibleLoss loss = referred_.loss().value_or(coded);
    // Of textures that too few references show, coding says the least.
    for (std::size_t i = 0; i < textures.size(); ++i)
        if (referred_.pixels[i] < fewest_pixels)
            loss.share_255[i] = std::max(loss.share_255[i], coded.share_255[i]);
    return loss;
}

std::optional<VisibleLoss> VisibleLossMeter::Sums::loss() const {
    if (std::ranges::none_of(pixels, [](double count) { return count >= fewest_pixels; }))
        return std::nullopt;
    VisibleLoss loss;
    for (std::size_t i = 0; i < textures.size(); ++i) {
        std::optional<std::size_t> nearest;
        for (std::size_t other = 0; other < textures.size(); ++other)
            if (pixels[other] >= fewest_pixels &&
                (!nearest || std::abs(textures[other] - textures[i]) < std::abs(textures[*nearest] - textures[i])))
                nearest = other;
        if (nearest)
            loss.share_255[i] = as_byte(lost[*nearest] / pixels[*nearest]);
    }
    return loss;
}

}  // namespace equistream
