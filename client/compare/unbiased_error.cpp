#include "unbiased_error.h"

#include <equistream/error.h>

#include <nlohmann/json.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <utility>

namespace equistream {

namespace {

void add_to(std::vector<double>& sums, const std::vector<double>& more) {
    if (more.empty())
        return;
    if (sums.empty())
        sums.assign(more.size(), 0.0);
    assert(sums.size() == more.size());
    std::transform(sums.begin(), sums.end(), more.begin(), sums.begin(), std::plus<>());
}

std::int64_t counted_pixels(int width, int height, ImageView<const std::uint8_t> mask) {
    if (mask.data == nullptr)
        return std::int64_t{width} * height;
    std::int64_t count = 0;
    for (int y = 0; y < height; ++y)
        count += std::count_if(mask.row(y), mask.row(y) + width, [](std::uint8_t value) { return value != 0; });
    return count;
}

/// 255 at the worst `fraction` of a run's pixels, 0 elsewhere.
ByteImage worst_pixels(const PictureAndTruth& run, double fraction) {
    const int width = run.picture.width;
    const int height = run.picture.height;
    FloatImage squares(width, height, 1);
    tbb::parallel_for(0, height, [&](int y) {
        const float* a = run.picture.row(y);
        const float* t = run.truth.row(y);
        for (int x = 0; x < width; ++x) {
            float square = 0;
            for (int i = 3 * x; i < 3 * x + 3; ++i)
                square += (a[i] - t[i]) * (a[i] - t[i]);
            *squares.pixel(x, y) = square;
        }
    });
    const auto& all = squares.samples();
    const auto wanted =
        std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(all.size()))));
    std::vector<float> sorted(all.begin(), all.end());
    const auto last = sorted.begin() + static_cast<std::ptrdiff_t>(wanted - 1);
    std::nth_element(sorted.begin(), last, sorted.end(), std::greater<>());
    const float least = *last;
    auto equals = wanted - static_cast<std::size_t>(
                               std::count_if(all.begin(), all.end(), [&](float square) { return square > least; }));
    ByteImage mask(width, height, 1);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const bool taken_as_equal = all[i] == least && equals > 0;
        equals -= taken_as_equal ? 1 : 0;
        mask.samples()[i] = all[i] > least || taken_as_equal ? 255 : 0;
    }
    return mask;
}

/// 97.5 % quantile of Student's t for one degree of freedom and more. From 3 up Abramowitz and Stegun 26.7.5, which is
/// within 1 %; below, between the exact values for 1, 2 and 3.
double student_quantile(double freedom) {
    const auto blend = [](double low, double high, double t) { return low * std::pow(high / low, t); };
    if (freedom < 2)
        return blend(12.7062, 4.3027, 2 - 2 / freedom);
    if (freedom < 3)
        return blend(4.3027, 3.1824, 3 - 6 / freedom);
    const double z = 1.959963984540054;
    const double z3 = z * z * z;
    const double z5 = z3 * z * z;
    const double z7 = z5 * z * z;
    return z + (z3 + z) / (4 * freedom) + (5 * z5 + 16 * z3 + 3 * z) / (96 * freedom * freedom) +
           (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * freedom * freedom * freedom);
}

namespace fs = std::filesystem;

/// What decided the noise.
struct Sampling {
    std::uint64_t seed = 0;
    std::uint32_t samples_per_pixel = 0;
};

}  // namespace

fs::path report_of_views(const fs::path& view) {
    return fs::absolute(view).parent_path().parent_path() / "report.json";
}

namespace {

/// What `play` wrote of its source; nothing where it did not, or where the file is somebody else's.
std::optional<Sampling> sampling_of_views(const fs::path& view) {
    std::ifstream file(report_of_views(view));
    const auto report = nlohmann::json::parse(file, nullptr, false);
    const nlohmann::json::json_pointer seed("/source/seed"), samples("/source/samples_per_pixel");
    for (const auto& number : {seed, samples})
        if (!report.contains(number) || !report[number].is_number_unsigned())
            return std::nullopt;
    return Sampling{report[seed].get<std::uint64_t>(), report[samples].get<std::uint32_t>()};
}

std::optional<Sampling> sampling_of(const ScoredPicture& picture) {
    if (!picture.info)
        return sampling_of_views(picture.file);
    if (picture.info->samples_per_pixel == 0)
        return std::nullopt;  // a foreign file
    return Sampling{picture.info->seed, picture.info->samples_per_pixel};
}

/// The same samples, and not one value throughout.
template <typename Sample>
bool same_samples(const Image<Sample>& a, const Image<Sample>& b) {
    const auto first = a.samples();
    const auto second = b.samples();
    const auto of_others = first.subspan(std::min(first.size(), std::size_t(a.channels())));
    const bool constant = std::ranges::equal(of_others, first.first(of_others.size()));
    return !constant && std::ranges::equal(first, second);
}

bool same_noise(const ScoredPicture& a, const ScoredPicture& b) {
    return a.linear == b.linear && (a.linear ? same_samples(a.radiance, b.radiance) : same_samples(a.rgb, b.rgb));
}

bool same_file(const fs::path& a, const fs::path& b) {
    std::error_code ignored;
    return a == b || fs::equivalent(a, b, ignored);
}

[[noreturn]] void refuse(const char* option, const ScoredPicture& picture, const std::string& expected,
                         const std::string& found) {
    throw InputError(expected_found(option + (": " + picture.file.string()), expected, found));
}

}  // namespace

void ProductBlocks::add(const ProductBlocks& other) {
    add_to(product, other.product);
    add_to(imbalance, other.imbalance);
    samples += other.samples;
}

ProductBlocks product_blocks(const PictureAndTruth& run_1, const PictureAndTruth& run_2,
                             ImageView<const std::uint8_t> mask) {
    const int width = run_1.picture.width;
    const int height = run_1.picture.height;
    for ([[maybe_unused]] const auto& view : {run_1.picture, run_1.truth, run_2.picture, run_2.truth})
        assert(view.width == width && view.height == height && view.channels == 3);
    const int columns = (width + product_block_px - 1) / product_block_px;
    const int rows = (height + product_block_px - 1) / product_block_px;
    ProductBlocks blocks;
    blocks.product.assign(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0.0);
    blocks.imbalance = blocks.product;
    blocks.samples = 3 * counted_pixels(width, height, mask);
    tbb::parallel_for(0, rows, [&](int block_row) {
        const int y_end = std::min(height, (block_row + 1) * product_block_px);
        for (int y = block_row * product_block_px; y < y_end; ++y) {
            const float* a1 = run_1.picture.row(y);
            const float* t1 = run_1.truth.row(y);
            const float* a2 = run_2.picture.row(y);
            const float* t2 = run_2.truth.row(y);
            const std::uint8_t* counts = mask.data == nullptr ? nullptr : mask.row(y);
            for (int column = 0; column < columns; ++column) {
                const int i_end = 3 * std::min(width, (column + 1) * product_block_px);
                float product = 0;
                float imbalance = 0;
                for (int i = 3 * column * product_block_px; i < i_end; ++i) {
                    if (counts != nullptr && counts[i / 3] == 0)
                        continue;
                    const float d1 = a1[i] - t1[i];
                    const float d2 = a2[i] - t2[i];
                    product += d1 * d2;
                    imbalance += 0.5f * (d1 - d2) * (d1 + d2);
                }
                const auto block = static_cast<std::size_t>(block_row) * static_cast<std::size_t>(columns) +
                                   static_cast<std::size_t>(column);
                blocks.product[block] += static_cast<double>(product);
                blocks.imbalance[block] += static_cast<double>(imbalance);
            }
        }
    });
    return blocks;
}

ProductBlocks worst_product_blocks(const PictureAndTruth& run_1, const PictureAndTruth& run_2, double fraction) {
    assert(fraction > 0 && fraction <= 1);
    ProductBlocks blocks = product_blocks(run_1, run_2, worst_pixels(run_1, fraction).view());
    blocks.add(product_blocks(run_1, run_2, worst_pixels(run_2, fraction).view()));
    return blocks;
}

double UnbiasedError::decibels(double mean_square) {
    return mean_square > 0 ? -10 * std::log10(mean_square) : std::numeric_limits<double>::infinity();
}

UnbiasedError unbiased_error(const ProductBlocks& blocks) {
    assert(blocks.samples > 0);
    double sum = 0;
    double variance = 0;
    double fourth = 0;
    for (std::size_t b = 0; b < blocks.product.size(); ++b) {
        const double square = blocks.imbalance[b] * blocks.imbalance[b];
        sum += blocks.product[b];
        variance += square;
        fourth += square * square;
    }
    // A few blocks may carry most of the noise: Satterthwaite's degrees of freedom for squares of one degree each,
    // with the correction for estimating them (E[Y^4] = 3 E[Y^2]^2, hence 3 and 2): 1 for a single block.
    const auto all = static_cast<double>(blocks.product.size());
    const double freedom = fourth > 0 ? std::min(all, 3 * variance * variance / fourth - 2) : all;
    const auto samples = static_cast<double>(blocks.samples);
    const double half_width = student_quantile(freedom) * std::sqrt(variance) / samples;
    UnbiasedError error;
    error.mean_square = sum / samples;
    error.low = error.mean_square - half_width;
    error.high = error.mean_square + half_width;
    error.samples = blocks.samples;
    error.blocks = static_cast<std::int64_t>(blocks.product.size());
    return error;
}

void require_independent(const char* option, const std::vector<NoisePair>& pairs) {
    const std::string expected = "noise of its own";
    for (const auto& [first, second] : pairs)
        if (same_file(first.file, second.file))
            refuse(option, second, expected, "the file " + first.file.string());
    for (const auto& [first, second] : pairs)
        if (same_noise(first, second))
            refuse(option, second, expected, "the contents of " + first.file.string());
    for (const auto& [first, second] : pairs) {
        const auto a = sampling_of(first), b = sampling_of(second);
        if (a && b && a->seed == b->seed)
            refuse(option, second, expected, "seed " + std::to_string(b->seed) + ", that of " + first.file.string());
    }
}

void require_as_many_samples(const char* option, const ScoredPicture& first, const ScoredPicture& second) {
    const auto a = sampling_of(first), b = sampling_of(second);
    if (a && b && a->samples_per_pixel != b->samples_per_pixel)
        refuse(option, second,
               "the " + std::to_string(a->samples_per_pixel) + " samples per pixel of " + first.file.string(),
               std::to_string(b->samples_per_pixel));
}

}  // namespace equistream
