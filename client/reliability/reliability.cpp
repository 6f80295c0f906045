#include "coefficients.h"
#include "map_kernels.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>

namespace equistream {

namespace {

using reliability_model::Group;
using reliability_model::groups;

/// The calibration table covers sums from 0 to its last entry; beyond that it stays.
inline std::uint8_t look_up(const Group& group, float sum) {
    const auto entry = int(std::min(sum * reliability_model::entries_per_unit, float(group.share_255.size() - 1)));
    return group.share_255[std::size_t(entry)];
}

/// Rows that one thread goes through at a time: their surroundings are computed anew for each band.
constexpr int band_rows = 64;

void estimate_plainly(const SourceView& source, const EyeView& eye, EyePicture& picture,
                      const ReliabilityOptions& options) {
    const int width = picture.origin.width();
    const RiskPicture risks(source, eye, picture, options);
    RiskRow row(width);
    std::vector<std::uint8_t> group(static_cast<std::size_t>(width));
    std::array<float, risk_count> here{};
    for (int y = 0; y < picture.origin.height(); ++y) {
        risks.row(y, row);
        risks.groups(y, group.data());
        for (int x = 0; x < width; ++x) {
            for (int k = 0; k < risk_count; ++k)
                here[std::size_t(k)] = row.of(Risk(k))[x];
            const std::uint8_t g = group[std::size_t(x)];
            picture.reliability.pixel(x, y)[0] =
                g == no_risk_group ? std::uint8_t(0) : std::uint8_t(255 * reliability_of(RiskGroup(g), here) + 0.5f);
            if (same_view(source, eye) && picture.origin.pixel(x, y)[0] == std::uint8_t(PixelOrigin::source))
                picture.reliability.pixel(x, y)[0] = 255;
        }
    }
}

}  // namespace

RiskGroup risk_group(PixelOrigin origin, KnownDepth depth, bool mirrored) {
    switch (origin) {
    case PixelOrigin::source:
        if (depth == KnownDepth::none)
            return RiskGroup::turned;
        if (mirrored)
            return RiskGroup::mirrored;
        return depth == KnownDepth::coarse ? RiskGroup::coarse : RiskGroup::source;
    case PixelOrigin::earlier:
    case PixelOrigin::patches:
    case PixelOrigin::hidden:
        return RiskGroup::seen;
    case PixelOrigin::small:
        return RiskGroup::small;
    default:
        return RiskGroup::guessed;
    }
}

float reliability_of(RiskGroup group, const std::array<float, risk_count>& risks) {
    const Group& weighted = groups[std::size_t(group)];
    float sum = 0;
    for (std::size_t k = 0; k < risks.size(); ++k)
        sum += weighted.weights[k] * risks[k];
    return float(look_up(weighted, sum)) * (1 / 255.0f);
}

void estimate_reliability(const SourceView& source, const EyeView& eye, EyePicture& picture,
                          const ReliabilityOptions& options) {
    const int width = picture.origin.width(), height = picture.origin.height();
    picture.reliability = ByteImage(width, height, 1);
    if (options.reference || width < least_map_width + 2) {
        estimate_plainly(source, eye, picture, options);
        return;
    }
    const RiskNumbers numbers(source, eye, picture, options);
    ByteImage contrast(width, height, 1), along(width, height, 1), filled;
    MapJob job{.numbers = numbers,
               .picture = picture,
               .rays = EyeRays(eye.camera, eye.pose, source.pose),
               .grid = source_grid(source.camera),
               .specular = source.specular,
               .untouched = same_view(source, eye)};
    job.contrast = contrast.view();
    job.along = along.view();
    job.out = picture.reliability.view();
    using Range = tbb::blocked_range<int>;
    std::atomic<bool> others{false};
    tbb::parallel_for(Range(0, height, band_rows), [&](const Range& rows) {
        if (find_differences(job, rows.begin(), rows.end()))
            others = true;
    });
    if (others) {
        constexpr int strip = 256;
        filled = ByteImage(width, height, 1);
        job.filled = filled.view();
        tbb::parallel_for(0, (width + strip - 1) / strip,
                          [&](int i) { fill_columns(job, i * strip, std::min(width, (i + 1) * strip)); });
    }
    tbb::parallel_for(
        Range(0, height, band_rows), [&](const Range& rows) { judge_rows(job, rows.begin(), rows.end()); },
        tbb::simple_partitioner());
}

}  // namespace equistream
