#include "sphere_history.h"

#include <equistream/bound.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace equistream {

namespace {

constexpr int rows_of_a_task = 16;
/// In rows nearer a pole than this longitudes turn too fast, but pixels are slivers: one in `polar_step` is cast, and
/// edges between are off by no more than a fifth of a pixel's angle.
constexpr float least_cos_latitude = 0.1f;
constexpr int polar_step = 4;
/// What lies between where an edge's two sides land is cast, and what is this near it: landing places are good to less.
constexpr float spare_px = 0.0625f;
/// Beyond this way in the units of the nearest distance, nothing is where it was.
constexpr float longest_way = 0.8f;

template <typename Work>
void by_rows(int height, const Work& work) {
    tbb::parallel_for(tbb::blocked_range<int>(0, height, rows_of_a_task), [&](const tbb::blocked_range<int>& range) {
        for (int y = range.begin(); y < range.end(); ++y)
            work(y);
    });
}

/// Several threads may mark one pixel.
void mark(std::uint8_t* row, int x) {
    std::atomic_ref<std::uint8_t>(row[x]).store(1, std::memory_order_relaxed);
}

/// Columns from `first` to `last`, round the seam where the picture closes.
void mark_columns(std::uint8_t* row, int first, int last, const EquirectCamera& camera) {
    last = std::min(last, first + camera.width - 1);
    for (int x = first; x <= last; ++x) {
        if (x >= 0 && x < camera.width)
            mark(row, x);
        else if (camera.range.closes())
            mark(row, (x % camera.width + camera.width) % camera.width);
    }
}

}  // namespace

SphereHistory::SphereHistory(const EquirectCamera& camera, const ReuseBound& bound)
    : camera_(camera), bound_(bound), inverse_m_(camera.width, camera.height), cost_(camera.width, camera.height),
      edges_(std::size_t(camera.height)) {
    for (int x = 0; x < camera.width + PaddedPlane::margin; ++x) {
        const double longitude = camera.range.longitude_min + (x + 0.5) * camera.range.longitude_span() / camera.width;
        sin_longitude_.push_back(float(std::sin(longitude)));
        cos_longitude_.push_back(float(std::cos(longitude)));
    }
    for (int y = 0; y < camera.height; ++y) {
        const double latitude = camera.range.latitude_max - (y + 0.5) * camera.range.latitude_span() / camera.height;
        sin_latitude_.push_back(float(std::sin(latitude)));
        cos_latitude_.push_back(float(std::cos(latitude)));
    }
}

SphereWarp SphereHistory::warp_to(const Pose& pose) const {
    const glm::vec3 way(glm::conjugate(pose_.orientation) * (pose.position_m - pose_.position_m));
    return {&inverse_m_,
            &cost_,
            camera_.width,
            camera_.height,
            float(camera_.width / camera_.range.longitude_span()),
            float(camera_.height / camera_.range.latitude_span()),
            way.x,
            way.y,
            way.z,
            sin_longitude_.data(),
            cos_longitude_.data(),
            float(bound_.box_radius_m),
            float(bound_.error)};
}

bool SphereHistory::mark_edges(const SphereWarp& warp, CastMask& cast) const {
    std::atomic<bool> all = false;
    by_rows(camera_.height, [&](int y) {
        const float sin_p = sin_latitude_[std::size_t(y)];
        // Next to a pole all is cast; how far sideways edges there go does not matter.
        const float cos_p = std::max(cos_latitude_[std::size_t(y)], least_cos_latitude);
        for (const EdgeCell& edge : edges_[std::size_t(y)]) {
            const float sin_l = sin_longitude_[std::size_t(edge.x)], cos_l = cos_longitude_[std::size_t(edge.x)];
            const float heading = warp.x_m * sin_l - warp.z_m * cos_l;
            const float across = (warp.x_m * cos_l + warp.z_m * sin_l) * warp.columns_per_rad / cos_p;
            const float up = (warp.y_m * cos_p - sin_p * heading) * warp.rows_per_rad;
            const float along = heading * cos_p + warp.y_m * sin_p;
            if (edge.highest_inverse_m * std::abs(along) > longest_way) {
                all = true;
                return;
            }
            const float near = edge.highest_inverse_m / (1 - edge.highest_inverse_m * along);
            const float far = edge.lowest_inverse_m / (1 - edge.lowest_inverse_m * along);
            const auto [left, right] = std::minmax({-across * near, -across * far});
            const auto [top, bottom] = std::minmax({up * near, up * far});
            const int first_row = std::max(0, y + int(std::ceil(top - spare_px)));
            const int last_row = std::min(camera_.height - 1, y + 1 + int(std::floor(bottom + spare_px)));
            for (int row = first_row; row <= last_row; ++row)
                mark_columns(cast.row(row), edge.x + int(std::ceil(left - spare_px)),
                             edge.x + 1 + int(std::floor(right + spare_px)), camera_);
        }
    });
    return !all;
}

void SphereHistory::mark_ball(const MoverBall& ball, const Pose& pose, CastMask& cast) const {
    const glm::dvec3 towards = glm::conjugate(pose.orientation) * (ball.centre_m - pose.position_m);
    const double distance_m = glm::length(towards);
    if (distance_m <= ball.radius_m)
        return cast.set_all(1);
    const double pixel = camera_.range.latitude_span() / camera_.height;
    const double angle = std::asin(ball.radius_m / distance_m) + 2 * pixel;
    const double latitude = std::asin(std::clamp(towards.y / distance_m, -1.0, 1.0));
    const glm::dvec2 middle = camera_.pixel(towards);
    const bool over_pole = std::abs(latitude) + angle >= 0.5 * pi;
    const double half_width = over_pole ? camera_.width
                                        : std::asin(std::min(1.0, std::sin(angle) / std::cos(latitude))) *
                                              camera_.width / camera_.range.longitude_span();
    const double half_height = angle / pixel;
    const int first = std::max(0, int(std::floor(middle.y - half_height)));
    const int last = std::min(camera_.height - 1, int(std::ceil(middle.y + half_height)));
    for (int y = first; y <= last; ++y)
        mark_columns(cast.row(y), int(std::floor(middle.x - half_width)) - 1, int(std::ceil(middle.x + half_width)) + 1,
                     camera_);
}

bool SphereHistory::carry(const SphereHistory& last, const Pose& pose, std::span<const MoverBall> movers_now,
                          CastMask& cast, ImageView<float> depth_m) {
    const SphereWarp warp = last.warp_to(pose);
    if (!last.mark_edges(warp, cast))
        return false;
    for (const std::span<const MoverBall> balls : {std::span<const MoverBall>(last.movers_), movers_now})
        for (const MoverBall& ball : balls)
            mark_ball(ball, pose, cast);
    tbb::parallel_for(tbb::blocked_range<int>(0, camera_.height, rows_of_a_task), [&](const auto& range) {
        std::vector<float> distance_m(std::size_t(camera_.width + PaddedPlane::margin));
        for (int y = range.begin(); y < range.end(); ++y) {
            const float sin_p = sin_latitude_[std::size_t(y)], cos_p = cos_latitude_[std::size_t(y)];
            if (cos_p < least_cos_latitude) {
                for (int x = 0; x < camera_.width; ++x)
                    cast.row(y)[x] = x % polar_step == 0 || x == camera_.width - 1;
                continue;
            }
            warp_row(warp, {y, sin_p, cos_p, cast.row(y), distance_m.data(), inverse_m_.row(y), cost_.row(y)});
            std::copy_n(distance_m.data(), camera_.width, depth_m.row(y));
        }
    });
    return true;
}

void SphereHistory::fill_poles(ImageView<float> depth_m) {
    const double box_m = bound_.box_radius_m;
    by_rows(camera_.height, [&](int y) {
        if (cos_latitude_[std::size_t(y)] >= least_cos_latitude)
            return;
        float* inverse_m = inverse_m_.row(y);
        for (int from = 0; from < camera_.width - 1; from += polar_step) {
            const int to = std::min(from + polar_step, camera_.width - 1);
            const float a = inverse_m[from], b = inverse_m[to];
            const bool joined = std::abs(bounded_inverse_depth(1 / a, box_m) - bounded_inverse_depth(1 / b, box_m)) <=
                                polar_step * bound_.error;
            for (int x = from + 1; x < to; ++x) {
                const float part = float(x - from) / float(to - from);
                const float s = joined ? a + (b - a) * part : part < 0.5f ? a : b;
                inverse_m[x] = s;
                cost_.row(y)[x] = 0;
                depth_m.pixel(x, y)[0] = 1 / s;
            }
        }
    });
}

void SphereHistory::finish(const Pose& pose, std::span<const MoverBall> movers) {
    pose_ = pose;
    movers_.assign(movers.begin(), movers.end());
    const SphereWarp bounds = warp_to(pose);
    const bool closes = camera_.range.closes();
    by_rows(camera_.height, [&](int y) { inverse_m_.pad(y, closes, 0); });
    by_rows(camera_.height, [&](int y) {
        edges_[std::size_t(y)].clear();
        add_interpolation_cost(inverse_m_, y, bounds, cost_.row(y), edges_[std::size_t(y)]);
        cost_.pad(y, closes, std::numeric_limits<float>::infinity());
    });
}

}  // namespace equistream
