#include "coefficients.h"
#include "map_kernels.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace equistream {

namespace {

using reliability_model::Group;
using reliability_model::groups;

/// The calibration table covers sums from 0 to its last entry; beyond that it stays.
inline std::uint8_t resample(const Group& group, float sum) {
    const auto entry = int(std::min(sum * reliability_model::entries_per_unit, float(group.share_255.size() - 1)));
    return group.share_255[std::size_t(entry)];
}

/// Rows that one thread goes through at a time: their surroundings are computed anew for each band.
constexpr int band_rows = 64;

/// In rows that hold as many as loops take at a time.
template <typename Sample>
Image<Sample> widened(ImageView<const Sample> plane, int width) {
    Image<Sample> wide(width, plane.height, plane.channels);
    for (int y = 0; y < plane.height; ++y)
        std::copy_n(plane.row(y), std::size_t(plane.width) * std::size_t(plane.channels), wide.pixel(0, y));
    return wide;
}

/// Without the columns beyond `width`.
template <typename Sample>
ImageView<Sample> first_columns(ImageView<Sample> plane, int width) {
    plane.width = width;
    return plane;
}

/// What is asked for beside the map itself; both or neither.
struct Told {
    FloatImage* risks = nullptr;
    ByteImage* groups = nullptr;
};

ByteImage judge(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                const ReliabilityOptions& options, const Told& told) {
    RiskNumbers numbers(source, eye, picture, options);
    const int width = picture.origin.width(), height = picture.origin.height();
    const int row_width = std::max(width, min_map_width + 2);
    EyePicture wide;
    FloatImage wide_depth_m;
    if (row_width > width) {
        wide.rgba = widened(picture.rgba.view(), row_width);
        wide.origin = widened(picture.origin.view(), row_width);
        if (numbers.has_depth()) {
            wide_depth_m = widened(numbers.depth_m, row_width);
            numbers.depth_m = first_columns<const float>(wide_depth_m.view(), width);
        }
    }
    ByteImage contrast(row_width, height, 1), along(row_width, height, 1), filled, map(row_width, height, 1);
    MapJob job{.numbers = numbers,
               .picture = row_width > width ? wide : picture,
               .width = width,
               .rays = EyeRays(eye.camera, eye.pose, source.pose),
               .grid = source_grid(source.camera),
               .specular = source.specular,
               .untouched = same_view(source, eye)};
    job.contrast = first_columns(contrast.view(), width);
    job.along = along.view();
    job.out = map.view();
    if (told.risks != nullptr) {
        *told.risks = FloatImage(width, height, risk_count);
        *told.groups = ByteImage(width, height, 1);
        job.risks = told.risks->view();
        job.groups = told.groups->view();
    }
    using Range = tbb::blocked_range<int>;
    std::atomic<bool> others{false};
    tbb::parallel_for(Range(0, height, band_rows), [&](const Range& rows) {
        if (find_differences(job, rows.begin(), rows.end()))
            others = true;
    });
    if (others) {
        constexpr int strip = 256;
        filled = ByteImage(row_width, height, 1);
        job.filled = filled.view();
        tbb::parallel_for(0, (width + strip - 1) / strip,
                          [&](int i) { fill_columns(job, i * strip, std::min(width, (i + 1) * strip)); });
    }
    tbb::parallel_for(
        Range(0, height, band_rows), [&](const Range& rows) { judge_rows(job, rows.begin(), rows.end()); },
        tbb::simple_partitioner());
    return row_width > width ? widened<std::uint8_t>(first_columns(map.view(), width), width) : std::move(map);
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
    return float(resample(weighted, sum)) * (1 / 255.0f);
}

void estimate_reliability(const SourceView& source, const EyeView& eye, EyePicture& picture,
                          const ReliabilityOptions& options) {
    picture.reliability = judge(source, eye, picture, options, {});
}

FloatImage reliability_risks(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options) {
    FloatImage risks;
    ByteImage groups;
    judge(source, eye, picture, options, {&risks, &groups});
    return risks;
}

ByteImage reliability_groups(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options) {
    FloatImage risks;
    ByteImage groups;
    judge(source, eye, picture, options, {&risks, &groups});
    return groups;
}

}  // namespace equistream
