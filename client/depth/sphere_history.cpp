#include "sphere_history.h"

#include "sphere_edges.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace equistream {

namespace {

constexpr int rows_of_a_task = 16;
/// Of polar rows, whose pixels are slivers, one in so many is cast: edges between are off by no more than a fifth of a
/// pixel's angle.
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

}  // namespace

SphereHistory::SphereHistory(const EquirectCamera& camera, const ReuseBound& bound, const SurfacePlanes& planes)
    : camera_(camera), bound_(bound), planes_(&planes), angles_(camera), tiles_(camera_, angles_),
      seen_(camera.width, camera.height), cells_(camera.width, camera.height), edges_(std::size_t(camera.height)) {}

/// This picture's planes, met from `pose`.
SphereWarp SphereHistory::warp_from(const Pose& pose) const {
    const glm::vec3 way(glm::conjugate(pose_.orientation) * (pose.position_m - pose_.position_m));
    const glm::vec3 from(pose.position_m);
    return {&seen_,
            &cells_,
            planes_->values(),
            camera_.width,
            camera_.height,
            float(camera_.width / camera_.range.longitude_span()),
            float(camera_.height / camera_.range.latitude_span()),
            {from.x, from.y, from.z},
            way.x,
            way.y,
            way.z,
            angles_.sin_longitude(),
            angles_.cos_longitude(),
            {angles_.column_world(0), angles_.column_world(1), angles_.column_world(2)},
            float(bound_.box_radius_m),
            float(bound_.error)};
}

bool SphereHistory::mark_edges(const SphereWarp& warp, CastMask& cast) const {
    std::atomic<bool> all = false;
    by_rows(camera_.height, [&](int y) {
        const float sin_p = angles_.sin_latitude(y);
        // How far sideways an edge goes next to a pole does not matter: rows there are cast whole where one comes.
        const float cos_p = std::max(angles_.cos_latitude(y), least_cos_latitude);
        for (const Edge& edge : edges_[std::size_t(y)]) {
            const float sin_l = angles_.sin_longitude()[edge.x], cos_l = angles_.cos_longitude()[edge.x];
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
                if (angles_.is_polar(row) && !angles_.is_polar(y))
                    cast.mark(row, 0, camera_.width - 1, camera_);
                else
                    cast.mark(row, edge.x + int(std::ceil(left - spare_px)),
                              edge.x + 1 + int(std::floor(right + spare_px)), camera_);
        }
    });
    return !all;
}

bool SphereHistory::carry(const SphereHistory& last, const Pose& pose, std::span<const MoverBall> movers_now,
                          CastMask& cast, ImageView<float> depth_m) {
    const SphereWarp warp = last.warp_from(pose);
    if (!last.mark_edges(warp, cast))
        return false;
    for (const std::span<const MoverBall> balls : {std::span<const MoverBall>(last.movers_), movers_now})
        for (const MoverBall& ball : balls)
            cast.mark_ball(ball, camera_, pose);
    const std::int32_t caps[] = {last.tiles_.cap(warp, true), last.tiles_.cap(warp, false)};
    tbb::parallel_for(tbb::blocked_range<int>(0, tiles_.rows()), [&](const auto& range) {
        std::vector<float> distance_m(std::size_t(camera_.width + PlaneNumbers::margin));
        std::vector<std::int32_t> planes(static_cast<std::size_t>(tiles_.columns()));
        for (int tile_row = range.begin(); tile_row < range.end(); ++tile_row) {
            for (int i = 0; i < tiles_.columns(); ++i)
                planes[std::size_t(i)] = last.tiles_.still_seen(warp, i, tile_row);
            const int end = std::min(camera_.height, (tile_row + 1) * carried_tile_height);
            for (int y = tile_row * carried_tile_height; y < end; ++y) {
                const SphereRow row = last.angles_.row(y);
                const NewRow now{cast.row(y), distance_m.data(), seen_.row(y)};
                const std::int32_t cap = caps[y < camera_.height / 2 ? 0 : 1];
                if (angles_.is_polar(y) && cap == mixed) {
                    for (int x = 0; x < camera_.width; ++x)
                        cast.row(y)[x] |= std::uint8_t(x % polar_step == 0 || x == camera_.width - 1);
                    continue;
                }
                if (angles_.is_polar(y))
                    fill_columns(warp, row, now, 0, camera_.width, cap);
                else
                    warp_tiles(warp, row, now, planes);
                std::copy_n(distance_m.data(), camera_.width, depth_m.row(y));
            }
        }
    });
    polar_cast_[0] = caps[0] == mixed;
    polar_cast_[1] = caps[1] == mixed;
    return true;
}

/// Tiles in a row that see one plane, or none, at once.
void SphereHistory::warp_tiles(const SphereWarp& warp, const SphereRow& row, const NewRow& now,
                               const std::vector<std::int32_t>& planes) const {
    for (int from = 0, to = 0; from < tiles_.columns(); from = to) {
        const std::int32_t plane = planes[std::size_t(from)];
        while (to < tiles_.columns() && planes[std::size_t(to)] == plane)
            ++to;
        const int first = from * carried_tile_width, last = std::min(to * carried_tile_width, camera_.width);
        if (plane == mixed)
            warp_columns(warp, row, now, first, last);
        else
            fill_columns(warp, row, now, first, last, plane);
    }
}

void SphereHistory::fill_poles(CastMask& cast, ImageView<float> depth_m) {
    by_rows(camera_.height, [&](int y) {
        if (!angles_.is_polar(y) || !polar_cast_[y < camera_.height / 2 ? 0 : 1])
            return;
        std::int32_t* seen = seen_.row(y);
        float* distance_m = depth_m.row(y);
        for (int from = 0; from < camera_.width - 1; from += polar_step) {
            const int to = std::min(from + polar_step, camera_.width - 1);
            for (int x = from + 1; x < to; ++x) {
                if (cast.row(y)[x] != 0)
                    continue;
                const int nearest = x - from < to - x ? from : to;
                seen[x] = seen[nearest];
                distance_m[x] = distance_m[nearest];
            }
        }
    });
}

void SphereHistory::finish(const Pose& pose, std::span<const MoverBall> movers, ImageView<const float> depth_m) {
    angles_.turn(pose.orientation);
    pose_ = pose;
    movers_.assign(movers.begin(), movers.end());
    const SphereWarp here = warp_from(pose);
    const bool closes = camera_.range.closes();
    by_rows(camera_.height, [&](int y) { seen_.pad(y, closes, SurfacePlanes::none); });
    tbb::parallel_for(tbb::blocked_range<int>(0, tiles_.rows()), [&](const auto& range) {
        std::vector<int> columns;
        PlaneRow planes(camera_.width), planes_below(camera_.width);
        for (int tile_row = range.begin(); tile_row < range.end(); ++tile_row) {
            const int top = tile_row * carried_tile_height, end = std::min(camera_.height, top + carried_tile_height);
            for (int i = 0; i < tiles_.columns(); ++i)
                tiles_.seen(i, tile_row) = seen_.row(top)[i * carried_tile_width];
            spread_planes(here, top, planes);
            for (int y = top; y < end; ++y) {
                const int below = std::min(y + 1, camera_.height - 1);
                spread_planes(here, below, planes_below);
                columns.clear();
                find_edges(here, {angles_.row(y), angles_.row(below), planes, planes_below}, cells_.row(y),
                           &tiles_.seen(0, tile_row), columns);
                cells_.pad(y, closes, Cell::parted);
                std::swap(planes, planes_below);
                std::vector<Edge>& edges = edges_[std::size_t(y)];
                edges.clear();
                for (const int x : columns) {
                    const int next = x + 1 < camera_.width ? x + 1 : closes ? 0 : x;
                    const auto [nearest, farthest] =
                        std::minmax({depth_m.pixel(x, y)[0], depth_m.pixel(next, y)[0], depth_m.pixel(x, below)[0],
                                     depth_m.pixel(next, below)[0]});
                    edges.push_back({x, 1 / farthest, 1 / nearest});
                }
            }
        }
    });
}

}  // namespace equistream
