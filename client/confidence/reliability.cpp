#include "reliability.h"

#include "map_kernels.h"

#include <equistream/bound.h>

#include <client/warp/engine.h>
#include <client/warp/plane_size.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace equistream {

namespace {

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
    case PixelOrigin::base:
        return RiskGroup::small;
    default:
        return RiskGroup::guessed;
    }
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

namespace {

constexpr float max_radii_outside = 2;
constexpr int longest_step = 8;

/// Rows of a sphere per radian; a flat view's at its middle, where they are fewest.
double density_per_rad(const Camera& camera) {
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera))
        return sphere->height / sphere->range.latitude_span();
    return std::get<PerspectiveCamera>(camera).focal_px();
}

ImageView<const float> depth_of(const EyeView& eye, const EyePicture& picture) {
    if (eye.depth_m.data != nullptr)
        return eye.depth_m;
    return picture.depth_m.empty() ? ImageView<const float>{} : picture.depth_m.view();
}

/// Mask and depth are gathered from by index, which nothing else would stop at their ends.
void require_sizes(const SourceView& source, const EyeView& eye, const EyePicture& picture) {
    const int width = eye.camera.width, height = eye.camera.height;
    require_plane_size("reliability: colours", picture.rgba.view(), {width, height, 4});
    require_plane_size("reliability: origins", picture.origin.view(), {width, height, 1});
    if (const ImageView<const float> depth_m = depth_of(eye, picture); depth_m.data != nullptr)
        require_plane_size("reliability: depth of the eye", depth_m, {width, height, 1});
    if (source.specular.data != nullptr)
        require_plane_size("reliability: specular mask", source.specular,
                           {width_of(source.camera), height_of(source.camera), 1});
}

}  // namespace

RiskNumbers::RiskNumbers(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                         const ReliabilityOptions& options)
    : RiskNumbers(source, eye, depth_of(eye, picture).data != nullptr, options) {
    depth_m = depth_of(eye, picture);
    require_sizes(source, eye, picture);
}

RiskNumbers::RiskNumbers(const SourceView& source, const EyeView& eye, bool has_depth,
                         const ReliabilityOptions& options) {
    const glm::dvec3 centre_world = source.pose.position_m - eye.pose.position_m;
    const glm::dvec3 in_eye = glm::conjugate(eye.pose.orientation) * centre_world;
    const double focal = eye.camera.focal_px();
    centre = {float(in_eye.x), float(in_eye.y), float(in_eye.z)};
    baseline_m = float(glm::length(centre_world));
    focal_px = float(focal);
    density = float(density_per_rad(source.camera) / focal);
    step = std::clamp(int(std::lround(1 / density)), 1, longest_step);
    texture_reach = texture_steps * step;
    const double box = source.box_radius_m > 0 ? source.box_radius_m : baseline_m;
    if (box > 0) {
        const double share = baseline_m / box;
        outside = float(std::clamp(share - 1 - 1e-6, 0.0, double(max_radii_outside)));
        depth_error_px = float(options.depth_tolerance_w * share * focal);
    }
    // Far outside the box w is B / r, so a step of w is B times one of 1 / r.
    min_step_inverse_m = float(error_budget_rad(focal) / std::max<double>(baseline_m, 1e-6));
    if (std::holds_alternative<EquirectCamera>(source.camera)) {
        const glm::dvec3 up = glm::conjugate(eye.pose.orientation) * (source.pose.orientation * glm::dvec3(0, 1, 0));
        pole = {float(up.x), float(up.y), float(up.z)};
    }
    const bool moved = !same_position(source.pose, eye.pose);
    if (moved && !has_depth)
        known = KnownDepth::none;
    else if (depth_error_px > default_budget_share * error_budget_rad(focal) * focal)
        known = KnownDepth::coarse;
    visible_loss = options.visible_loss.value_or(VisibleLoss{});
    mirrors = source.specular.data != nullptr && !options.specular_reworked && has_depth && moved;
}

bool same_view(const SourceView& source, const EyeView& eye) {
    return same_camera(source.camera, eye.camera) && same_pose(source.pose, eye.pose);
}

}  // namespace equistream
