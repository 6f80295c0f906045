#include "picture_metrics.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace equistream {

namespace {

constexpr std::uint32_t max_pixel_error = 3 * 255 * 255;

/// Adds up row sums that were computed in parallel, in the order of the rows.
template <typename RowSum>
ErrorSum sum_rows(int height, RowSum row_sum) {
    std::vector<ErrorSum> rows(static_cast<std::size_t>(height));
    tbb::parallel_for(0, height, [&](int y) { rows[static_cast<std::size_t>(y)] = row_sum(y); });
    ErrorSum total;
    for (const ErrorSum& row : rows)
        total += row;
    return total;
}

constexpr int radius = similarity_window / 2;
constexpr float luminance_constant = 0.01f * 255 * 0.01f * 255;
constexpr float contrast_constant = 0.03f * 255 * 0.03f * 255;
/// Variances are differences of large numbers: taken around mid-grey, float keeps four more bits of them.
constexpr float mid_grey = 128;

/// One side of the window, normalised: the Gaussian is separable and symmetric.
std::array<float, similarity_window> window_weights() {
    std::array<double, similarity_window> gaussian{};
    double sum = 0;
    for (int i = 0; i < similarity_window; ++i) {
        const double distance = (i - radius) / 1.5;
        sum += gaussian[static_cast<std::size_t>(i)] = std::exp(-0.5 * distance * distance);
    }
    std::array<float, similarity_window> weights{};
    for (std::size_t i = 0; i < weights.size(); ++i)
        weights[i] = static_cast<float>(gaussian[i] / sum);
    return weights;
}

/// Weighted sums over the window's columns, one value a sample of a row: of the picture p, the truth t,
/// p^2 + t^2 and p t, all less mid-grey. Four sums suffice: the formula needs the variances only added up.
struct WindowSums {
    std::vector<float> p, t, squares, product;

    void resize(std::size_t samples) {
        for (auto* sums : {&p, &t, &squares, &product})
            sums->assign(samples, 0.f);
    }
};

/// Filters rows y - radius to y + radius vertically into `sums`.
void filter_columns(ImageView<const std::uint8_t> picture, ImageView<const std::uint8_t> truth, int y,
                    const std::array<float, similarity_window>& weights, WindowSums& sums) {
    const int samples = 3 * picture.width;
    sums.resize(static_cast<std::size_t>(samples));
    for (int k = 0; k < similarity_window; ++k) {
        const std::uint8_t* picture_row = picture.row(y - radius + k);
        const std::uint8_t* truth_row = truth.row(y - radius + k);
        const float weight = weights[static_cast<std::size_t>(k)];
        for (int i = 0; i < samples; ++i) {
            const float p = static_cast<float>(picture_row[i]) - mid_grey;
            const float t = static_cast<float>(truth_row[i]) - mid_grey;
            sums.p[static_cast<std::size_t>(i)] += weight * p;
            sums.t[static_cast<std::size_t>(i)] += weight * t;
            sums.squares[static_cast<std::size_t>(i)] += weight * (p * p + t * t);
            sums.product[static_cast<std::size_t>(i)] += weight * (p * t);
        }
    }
}

/// Filters along the row: out[i] covers columns i to i + 2 radius of the same channel.
void filter_row(const std::vector<float>& in, const std::array<float, similarity_window>& weights,
                std::vector<float>& out) {
    const std::size_t windows = in.size() - 6 * radius;
    out.assign(windows, 0.f);
    for (std::size_t k = 0; k < weights.size(); ++k)
        for (std::size_t i = 0; i < windows; ++i)
            out[i] += weights[k] * in[i + 3 * k];
}

float similarity(float p, float t, float squares, float product) {
    const float variances = squares - p * p - t * t;
    const float covariance = product - p * t;
    const float mean_p = p + mid_grey;
    const float mean_t = t + mid_grey;
    return (2 * mean_p * mean_t + luminance_constant) * (2 * covariance + contrast_constant) /
           ((mean_p * mean_p + mean_t * mean_t + luminance_constant) * (variances + contrast_constant));
}

struct Scratch {
    WindowSums columns, windows;
};

Similarity similarity_of_row(const WindowSums& windows, const std::uint8_t* mask) {
    Similarity row;
    for (std::size_t i = 0; i < windows.p.size(); ++i) {
        const double value = similarity(windows.p[i], windows.t[i], windows.squares[i], windows.product[i]);
        row.all.sum += value;
        if (mask && mask[i / 3 + radius])
            row.masked += {value, 1};
    }
    row.all.windows = static_cast<double>(windows.p.size());
    return row;
}

}  // namespace

double ErrorSum::psnr_db() const {
    if (!(samples > 0))
        return std::numeric_limits<double>::quiet_NaN();
    if (sum <= 0)
        return std::numeric_limits<double>::infinity();
    return 10 * std::log10(255.0 * 255.0 / mean_square());
}

ErrorPlane squared_errors(ImageView<const std::uint8_t> picture, ImageView<const std::uint8_t> truth) {
    assert(picture.width == truth.width && picture.height == truth.height);
    assert(picture.channels == 3 && truth.channels == 3);
    ErrorPlane errors(picture.width, picture.height, 1);
    const auto out = errors.view();
    tbb::parallel_for(0, picture.height, [&](int y) {
        const std::uint8_t* a = picture.row(y);
        const std::uint8_t* b = truth.row(y);
        std::uint32_t* e = out.row(y);
        for (int x = 0; x < picture.width; ++x) {
            const int red = a[3 * x] - b[3 * x];
            const int green = a[3 * x + 1] - b[3 * x + 1];
            const int blue = a[3 * x + 2] - b[3 * x + 2];
            e[x] = static_cast<std::uint32_t>(red * red + green * green + blue * blue);
        }
    });
    return errors;
}

ErrorSum total_error(const ErrorPlane& errors) {
    return sum_rows(errors.height(), [&](int y) {
        const std::uint32_t* row = errors.view().row(y);
        const auto sum = std::accumulate(row, row + errors.width(), std::uint64_t{0});
        return ErrorSum{static_cast<double>(sum), 3.0 * errors.width()};
    });
}

ErrorSum total_error_where(const ErrorPlane& errors, ImageView<const std::uint8_t> mask) {
    assert(mask.width == errors.width() && mask.height == errors.height() && mask.channels == 1);
    return sum_rows(errors.height(), [&](int y) {
        const std::uint32_t* row = errors.view().row(y);
        const std::uint8_t* inside = mask.row(y);
        std::uint64_t sum = 0;
        int pixels = 0;
        for (int x = 0; x < errors.width(); ++x) {
            sum += inside[x] ? row[x] : 0;
            pixels += inside[x] ? 1 : 0;
        }
        return ErrorSum{static_cast<double>(sum), 3.0 * pixels};
    });
}

ErrorSum sphere_error(const ErrorPlane& errors, const LongitudeLatitudeRange& range) {
    return sum_rows(errors.height(), [&](int y) {
        const std::uint32_t* row = errors.view().row(y);
        const auto sum = std::accumulate(row, row + errors.width(), std::uint64_t{0});
        const double weight = equirect_pixel_solid_angle(y, errors.width(), errors.height(), range);
        return ErrorSum{weight * static_cast<double>(sum), weight * 3.0 * errors.width()};
    });
}

ErrorHistogram::ErrorHistogram() : pixels_(max_pixel_error + 1, 0) {}

void ErrorHistogram::add(const ErrorPlane& errors) {
    for (const std::uint32_t error : errors.samples())
        ++pixels_[error];
}

void ErrorHistogram::add(const ErrorHistogram& other) {
    std::transform(pixels_.begin(), pixels_.end(), other.pixels_.begin(), pixels_.begin(), std::plus<>());
}

ErrorSum ErrorHistogram::worst(double fraction) const {
    const auto counted = std::accumulate(pixels_.begin(), pixels_.end(), std::int64_t{0});
    if (counted == 0)
        return {};
    auto wanted = std::max<std::int64_t>(1, std::llround(std::ceil(fraction * static_cast<double>(counted))));
    ErrorSum worst;
    for (std::size_t error = pixels_.size(); error-- > 0 && wanted > 0;) {
        const auto taken = std::min(wanted, pixels_[error]);
        worst.sum += static_cast<double>(taken) * static_cast<double>(error);
        worst.samples += 3.0 * static_cast<double>(taken);
        wanted -= taken;
    }
    return worst;
}

Similarity structural_similarity(ImageView<const std::uint8_t> picture, ImageView<const std::uint8_t> truth,
                                 ImageView<const std::uint8_t> mask) {
    assert(picture.width == truth.width && picture.height == truth.height);
    assert(picture.channels == 3 && truth.channels == 3);
    assert(picture.width >= similarity_window && picture.height >= similarity_window);
    const auto weights = window_weights();
    const int rows = picture.height - 2 * radius;
    std::vector<Similarity> similarities(static_cast<std::size_t>(rows));
    tbb::enumerable_thread_specific<Scratch> scratch;
    tbb::parallel_for(0, rows, [&](int row) {
        auto& [columns, windows] = scratch.local();
        filter_columns(picture, truth, row + radius, weights, columns);
        filter_row(columns.p, weights, windows.p);
        filter_row(columns.t, weights, windows.t);
        filter_row(columns.squares, weights, windows.squares);
        filter_row(columns.product, weights, windows.product);
        similarities[static_cast<std::size_t>(row)] =
            similarity_of_row(windows, mask.data ? mask.row(row + radius) : nullptr);
    });
    Similarity total;
    for (const Similarity& row : similarities) {
        total.all += row.all;
        total.masked += row.masked;
    }
    return total;
}

}  // namespace equistream
