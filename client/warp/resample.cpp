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
    const double sample_rad = pixel_angle_rad(source.camera);
    WarpJob job{.grid = source_grid(source.camera),
                .source = source,
                .eye = eye,
                .rays = EyeRays(eye.camera, eye.pose, source.pose),
                .surface = surface,
                .only_seen = options.only_seen,
                .agreement = {},
                .interpolation =
                    float(std::min(interpolation_share * options.tolerance_rad / sample_rad, max_interpolation_error)),
                .radians_per_sample = float(sample_rad),
                .mark = options.mark,
                .only_gaps = options.only_gaps,
                .rgba = picture.rgba.view(),
                .origin = picture.origin.view()};
    job.agreement = {std::max(float(source.box_radius_m), job.rays.distance_m()),
                     float(std::sin(options.tolerance_rad))};
    // Few rows at once: some are many times as much work as others, and the last part is waited for.
    constexpr int rows_at_once = 2;
    const int rows = (eye.camera.height + tile_height - 1) / tile_height;
    std::atomic<std::int64_t> coloured{0};
    tbb::parallel_for(tbb::blocked_range<int>(0, rows, rows_at_once), [&](const tbb::blocked_range<int>& range) {
        coloured += warp_tiles(job, range.begin(), range.end());
    });
    return coloured;
}

}  // namespace

SourceGrid source_grid(const Camera& camera) {
    SourceGrid grid;
    grid.width = width_of(camera);
    grid.height = height_of(camera);
    grid.half_width = 0.5f * float(grid.width);
    grid.half_height = 0.5f * float(grid.height);
    if (const auto* flat = std::get_if<PerspectiveCamera>(&camera)) {
        grid.sphere = false;
        grid.focal_px = float(flat->focal_px());
        return grid;
    }
    const LongitudeLatitudeRange& range = std::get<EquirectCamera>(camera).range;
    grid.middle = float(0.5 * (range.longitude_min + range.longitude_max));
    grid.top = float(range.latitude_max);
    grid.columns_per_radian = float(grid.width / range.longitude_span());
    grid.rows_per_radian = float(grid.height / range.latitude_span());
    grid.closes = range.closes();
    grid.north_pole = grid.closes && range.latitude_max > pi / 2 - 1e-9;
    grid.south_pole = grid.closes && range.latitude_min < -pi / 2 + 1e-9;
    return grid;
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

namespace {

/// Of a lattice coordinate from -1 to n: a pixel's centre, or the picture's edge.
double centre_or_edge(int i, int n) {
    return std::clamp(i + 0.5, 0.0, double(n));
}

}  // namespace

LatticeAngles::LatticeAngles(const Camera& camera) {
    const int w = width_of(camera), h = height_of(camera);
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera)) {
        const LongitudeLatitudeRange& range = sphere->range;
        for (int x = -1; x <= w; ++x) {
            const double longitude = range.longitude_min + centre_or_edge(x, w) * range.longitude_span() / w;
            column_a.push_back(float(std::sin(longitude)));
            column_b.push_back(float(std::cos(longitude)));
        }
        for (int y = -1; y <= h; ++y) {
            const double latitude = range.latitude_max - centre_or_edge(y, h) * range.latitude_span() / h;
            row_a.push_back(float(std::sin(latitude)));
            row_b.push_back(float(std::cos(latitude)));
        }
    } else {
        const double focal = std::get<PerspectiveCamera>(camera).focal_px();
        for (int x = -1; x <= w; ++x)
            column_a.push_back(float((centre_or_edge(x, w) - 0.5 * w) / focal));
        for (int y = -1; y <= h; ++y)
            row_a.push_back(float((0.5 * h - centre_or_edge(y, h)) / focal));
    }
}

}  // namespace equistream
