#include "resample.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cassert>
#include <cmath>

namespace equistream {

namespace {

/// Of the error budget, what interpolating positions may take.
constexpr double interpolation_share = 1 / 4.0;
/// And never more, samples: below that the weights' own steps begin to show.
constexpr double max_interpolation_error = 1 / 32.0;

SourceGrid grid_of(const EquirectCamera& camera) {
    const LongitudeLatitudeRange& range = camera.range;
    SourceGrid grid;
    grid.middle = float(0.5 * (range.longitude_min + range.longitude_max));
    grid.top = float(range.latitude_max);
    grid.columns_per_radian = float(camera.width / range.longitude_span());
    grid.rows_per_radian = float(camera.height / range.latitude_span());
    grid.closes = range.closes();
    grid.north_pole = grid.closes && range.latitude_max > pi / 2 - 1e-9;
    grid.south_pole = grid.closes && range.latitude_min < -pi / 2 + 1e-9;
    return grid;
}

SourceGrid grid_of(const PerspectiveCamera& camera) {
    SourceGrid grid;
    grid.sphere = false;
    grid.focal_px = float(camera.focal_px());
    return grid;
}

std::int64_t run(const WarpJob& job) {
    // Few rows at once: some are many times as much work as others, and the last part is waited for.
    constexpr int rows_at_once = 2;
    const int rows = (job.eye.camera.height + tile_height - 1) / tile_height;
    std::atomic<std::int64_t> coloured{0};
    tbb::parallel_for(tbb::blocked_range<int>(0, rows, rows_at_once), [&](const tbb::blocked_range<int>& range) {
        coloured += warp_tiles(job, range.begin(), range.end());
    });
    return coloured;
}

template <typename AnyCamera>
std::int64_t resample(const AnyCamera& camera, const ResampleOptions& options, WarpJob& job) {
    job.grid = source_grid(camera);
    job.radians_per_sample = float(camera.pixel_angle_rad());
    job.interpolation = float(
        std::min(interpolation_share * options.tolerance_rad / camera.pixel_angle_rad(), max_interpolation_error));
    return run(job);
}

[[maybe_unused]] bool fits(const SourceView& source) {
    const int width = width_of(source.camera), height = height_of(source.camera);
    const auto sized = [](const auto& plane, int w, int h) { return plane.width == w && plane.height == h; };
    if (source.rgb.data != nullptr)
        return sized(source.rgb, width, height) && source.rgb.channels >= 3;
    return width % 2 == 0 && height % 2 == 0 && sized(source.yuv.y, width, height) &&
           sized(source.yuv.cb, width / 2, height / 2) && sized(source.yuv.cr, width / 2, height / 2);
}

std::int64_t resample(const SourceView& source, const EyeView& eye, const ResampleOptions& options, bool surface,
                      EyePicture& picture) {
    assert(fits(source));
    WarpJob job{.grid = {},
                .source = source,
                .eye = eye,
                .rays = EyeRays(eye.camera, eye.pose, source.pose),
                .surface = surface,
                .only_seen = options.only_seen,
                .agreement = {},
                .mark = options.mark,
                .only_gaps = options.only_gaps,
                .rgba = picture.rgba.view(),
                .origin = picture.origin.view()};
    job.agreement = {std::max(float(source.box_radius_m), job.rays.distance_m()),
                     float(std::sin(options.tolerance_rad))};
    return std::visit([&](const auto& camera) { return resample(camera, options, job); }, source.camera);
}

}  // namespace

SourceGrid source_grid(const Camera& camera) {
    return std::visit(
        [](const auto& any) {
            SourceGrid grid = grid_of(any);
            grid.width = any.width;
            grid.height = any.height;
            grid.half_width = 0.5f * float(any.width);
            grid.half_height = 0.5f * float(any.height);
            return grid;
        },
        camera);
}

std::int64_t resample_by_direction(const SourceView& source, const EyeView& eye, const ResampleOptions& options,
                                   EyePicture& picture) {
    return resample(source, eye, options, false, picture);
}

std::int64_t resample_by_surface(const SourceView& source, const EyeView& eye, const ResampleOptions& options,
                                 EyePicture& picture) {
    assert(!options.only_seen ||
           (source.depth_m.width == width_of(source.camera) && source.depth_m.height == height_of(source.camera)));
    assert(eye.depth_m.width == eye.camera.width && eye.depth_m.height == eye.camera.height);
    return resample(source, eye, options, true, picture);
}

bool surface_hides(const DepthAgreement& agreement, const std::array<float, 16>& over_clearance, float s, float t,
                   float point_over_clearance) {
    return formulas::surface_hides(over_clearance.data(), s, t, point_over_clearance, agreement.box_radius_m,
                                   agreement.tolerance);
}

bool surface_hides(const DepthAgreement& agreement, const SourceGrid& grid, const ImageView<const float>& depth_m,
                   int u, int v, float point_over_clearance) {
    const int x0 = u >> position_bits, y0 = v >> position_bits;
    std::array<float, 16> over_clearance;
    for (int i = 0; i < 16; ++i) {
        const Sample sample = wrapped(grid, x0 - 1 + i % 4, y0 - 1 + i / 4);
        const float distance_m = depth_m.pixel(sample.x, sample.y)[0];
        over_clearance[std::size_t(i)] = distance_m > 0 ? 1 / agreement.clearance(distance_m) : std::nanf("");
    }
    const auto fraction = [](int position) { return float(position & (position_one - 1)) / position_one; };
    return surface_hides(agreement, over_clearance, fraction(u), fraction(v), point_over_clearance);
}

EquirectLookup::EquirectLookup(const EquirectCamera& camera) : grid_(source_grid(camera)) {
    sin_longitude_.reserve(std::size_t(camera.width));
    cos_longitude_.reserve(std::size_t(camera.width));
    for (int x = 0; x < camera.width; ++x) {
        const double longitude = camera.range.longitude_min + (x + 0.5) * camera.range.longitude_span() / camera.width;
        sin_longitude_.push_back(float(std::sin(longitude)));
        cos_longitude_.push_back(float(std::cos(longitude)));
    }
    sin_latitude_.reserve(std::size_t(camera.height));
    cos_latitude_.reserve(std::size_t(camera.height));
    for (int y = 0; y < camera.height; ++y) {
        const double latitude = camera.range.latitude_max - (y + 0.5) * camera.range.latitude_span() / camera.height;
        sin_latitude_.push_back(float(std::sin(latitude)));
        cos_latitude_.push_back(float(std::cos(latitude)));
    }
}

}  // namespace equistream
