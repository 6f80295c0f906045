#include "picture_metrics.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
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

}  // namespace

double ErrorSum::psnr_db() const {
    if (!(samples > 0))
        return std::numeric_limits<double>::quiet_NaN();
    if (sum <= 0)
        return std::numeric_limits<double>::infinity();
    return 10 * std::log10(255.0 * 255.0 / mean_square());
}

ErrorSum& ErrorSum::operator+=(const ErrorSum& other) {
    sum += other.sum;
    samples += other.samples;
    return *this;
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

}  // namespace equistream
