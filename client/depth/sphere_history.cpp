#include "sphere_history.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

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
/// Up to this turn, in radians, ways in the picture are longer than to first order by no more than this part.
constexpr float largest_turn = 0.1f, second_order = 0.25f;

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

SphereHistory::SphereHistory(const EquirectCamera& camera, const ReuseBound& bound, const SurfacePlanes& planes)
    : camera_(camera), bound_(bound), planes_(&planes), seen_(camera.width, camera.height),
      cells_(camera.width, camera.height), tile_columns_((camera.width + carried_tile_width - 1) / carried_tile_width),
      tile_rows_((camera.height + carried_tile_height - 1) / carried_tile_height),
      tiles_(std::size_t(tile_columns_) * std::size_t(tile_rows_), mixed), edges_(std::size_t(camera.height)) {
    for (int x = 0; x < camera.width + PlaneNumbers::margin; ++x) {
        const double longitude = camera.range.longitude_min + (x + 0.5) * camera.range.longitude_span() / camera.width;
        sin_longitude_.push_back(float(std::sin(longitude)));
        cos_longitude_.push_back(float(std::cos(longitude)));
    }
    for (int y = 0; y < camera.height; ++y) {
        const double latitude = camera.range.latitude_max - (y + 0.5) * camera.range.latitude_span() / camera.height;
        sin_latitude_.push_back(float(std::sin(latitude)));
        cos_latitude_.push_back(float(std::cos(latitude)));
    }
    for (std::vector<float>& axis : column_world_)
        axis.resize(sin_longitude_.size());
}

void SphereHistory::set_world(const glm::dquat& orientation) {
    const glm::dmat3 axes = glm::mat3_cast(orientation);
    for (std::size_t x = 0; x < sin_longitude_.size(); ++x) {
        const glm::dvec3 column = axes * glm::dvec3(sin_longitude_[x], 0, -cos_longitude_[x]);
        for (int axis = 0; axis < 3; ++axis)
            column_world_[axis][x] = float(column[axis]);
    }
    up_world_ = axes[1];
}

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
            sin_longitude_.data(),
            cos_longitude_.data(),
            {column_world_[0].data(), column_world_[1].data(), column_world_[2].data()},
            float(bound_.box_radius_m),
            float(bound_.error)};
}

SphereRow SphereHistory::row_at(int y) const {
    const float sin_p = sin_latitude_[std::size_t(y)];
    const glm::vec3 up(up_world_ * double(sin_p));
    return {y, sin_p, cos_latitude_[std::size_t(y)], {up.x, up.y, up.z}};
}

bool SphereHistory::is_polar(int y) const {
    return cos_latitude_[std::size_t(y)] < least_cos_latitude;
}

/// The inverse distance of a plane in a pixel's direction; NaN where that is not before it and outside the head box, or
/// so near that directions turn far.
float SphereHistory::met(const SphereWarp& warp, std::int32_t plane, int x, int y) const {
    const float* p = warp.planes + 4 * std::ptrdiff_t(plane);
    const SphereRow row = row_at(y);
    float towards = 0, distance = p[3];
    for (int axis = 0; axis < 3; ++axis) {
        towards += p[axis] * (row.cos_latitude * warp.column_world[axis][x] + row.world[axis]);
        distance -= p[axis] * warp.from_m[axis];
    }
    const float s = towards / distance;
    const float way_squared = warp.x_m * warp.x_m + warp.y_m * warp.y_m + warp.z_m * warp.z_m;
    const bool holds = s >= 0 && s * warp.box_radius_m < 1 && s * s * way_squared < largest_turn * largest_turn;
    return holds ? s : std::numeric_limits<float>::quiet_NaN();
}

/// The plane of a tile, if all that its pixels saw before, wherever that was, is of that plane; else `mixed`.
std::int32_t SphereHistory::plane_still_seen(const SphereWarp& warp, int tile_column, int tile_row) const {
    const std::int32_t plane = tile(tile_column, tile_row);
    if (plane <= SurfacePlanes::none)
        return mixed;
    const int left = tile_column * carried_tile_width, right = std::min(camera_.width, left + carried_tile_width) - 1;
    const int top = tile_row * carried_tile_height, bottom = std::min(camera_.height, top + carried_tile_height) - 1;
    float first_column = float(left), last_column = float(right), first_row = float(top), last_row = float(bottom);
    for (const int y : {top, bottom})
        for (const int x : {left, right}) {
            const float s = met(warp, plane, x, y);
            const float sin_l = sin_longitude_[std::size_t(x)], cos_l = cos_longitude_[std::size_t(x)];
            const float sin_p = sin_latitude_[std::size_t(y)], cos_p = cos_latitude_[std::size_t(y)];
            const float heading = warp.x_m * sin_l - warp.z_m * cos_l;
            const float columns = s * (warp.x_m * cos_l + warp.z_m * sin_l) * warp.columns_per_rad / cos_p;
            const float rows = -s * (warp.y_m * cos_p - sin_p * heading) * warp.rows_per_rad;
            // What the second order adds; a whole way is below the tile's next but one neighbour.
            const float spare = second_order * (std::abs(columns) + std::abs(rows)) + 1;
            if (!(std::abs(columns) + spare < 2 * carried_tile_width &&
                  std::abs(rows) + spare < 2 * carried_tile_height))
                return mixed;
            first_column = std::min(first_column, float(x) + columns - spare);
            last_column = std::max(last_column, float(x) + columns + spare);
            first_row = std::min(first_row, float(y) + rows - spare);
            last_row = std::max(last_row, float(y) + rows + spare);
        }
    if (first_row < 0 || last_row >= float(camera_.height - 1))
        return mixed;
    if (!camera_.range.closes() && (first_column < 0 || last_column >= float(camera_.width - 1)))
        return mixed;
    const int first = int(std::floor(first_column)), last = int(std::floor(last_column));
    const int rows[] = {int(first_row) / carried_tile_height, int(last_row) / carried_tile_height};
    const auto all_of_plane = [&](int from, int to) {
        for (int j = rows[0]; j <= rows[1]; ++j)
            for (int i = from / carried_tile_width; i <= to / carried_tile_width; ++i)
                if (tile(i, j) != plane)
                    return false;
        return true;
    };
    // Round the seam by pixels: the last tile may be narrower than the others.
    const int end = camera_.width;
    if (last - first >= end)
        return mixed;
    bool same = all_of_plane(std::max(first, 0), std::min(last, end - 1));
    if (first < 0)
        same = same && all_of_plane(first + end, end - 1);
    if (last >= end)
        same = same && all_of_plane(0, last - end);
    return same ? plane : mixed;
}

/// Where all rows next to a pole, and those that can come there, see one plane: it; else `mixed`.
std::int32_t SphereHistory::cap_plane(const SphereWarp& warp, bool top) const {
    constexpr int spare_rows = 2 * carried_tile_height;
    const auto from_pole = [&](int i) { return top ? i : camera_.height - 1 - i; };
    int rows = 0;
    while (rows < camera_.height && is_polar(from_pole(rows)))
        ++rows;
    if (rows == 0 || rows + spare_rows >= camera_.height)
        return mixed;
    const int first = std::min(from_pole(0), from_pole(rows + spare_rows)) / carried_tile_height;
    const int last = std::max(from_pole(0), from_pole(rows + spare_rows)) / carried_tile_height;
    const std::int32_t plane = tile(0, first);
    if (plane <= SurfacePlanes::none)
        return mixed;
    for (int j = first; j <= last; ++j)
        for (int i = 0; i < tile_columns_; ++i)
            if (tile(i, j) != plane)
                return mixed;
    const float way_m = std::sqrt(warp.x_m * warp.x_m + warp.y_m * warp.y_m + warp.z_m * warp.z_m);
    for (const int y : {from_pole(0), from_pole(rows)})
        for (int x = 0; x < camera_.width; x += carried_tile_width)
            if (!(met(warp, plane, x, y) * way_m * warp.rows_per_rad * (1 + second_order) <= spare_rows))
                return mixed;
    return plane;
}

bool SphereHistory::mark_edges(const SphereWarp& warp, CastMask& cast) const {
    std::atomic<bool> all = false;
    by_rows(camera_.height, [&](int y) {
        const float sin_p = sin_latitude_[std::size_t(y)];
        // How far sideways an edge goes next to a pole does not matter: rows there are cast whole where one comes.
        const float cos_p = std::max(cos_latitude_[std::size_t(y)], least_cos_latitude);
        for (const Edge& edge : edges_[std::size_t(y)]) {
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
                if (is_polar(row) && !is_polar(y))
                    mark_columns(cast.row(row), 0, camera_.width - 1, camera_);
                else
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
    const SphereWarp warp = last.warp_from(pose);
    if (!last.mark_edges(warp, cast))
        return false;
    for (const std::span<const MoverBall> balls : {std::span<const MoverBall>(last.movers_), movers_now})
        for (const MoverBall& ball : balls)
            mark_ball(ball, pose, cast);
    const std::int32_t caps[] = {last.cap_plane(warp, true), last.cap_plane(warp, false)};
    tbb::parallel_for(tbb::blocked_range<int>(0, tile_rows_), [&](const auto& range) {
        std::vector<float> distance_m(std::size_t(camera_.width + PlaneNumbers::margin));
        std::vector<std::int32_t> planes(static_cast<std::size_t>(tile_columns_));
        for (int tile_row = range.begin(); tile_row < range.end(); ++tile_row) {
            for (int i = 0; i < tile_columns_; ++i)
                planes[std::size_t(i)] = last.plane_still_seen(warp, i, tile_row);
            const int end = std::min(camera_.height, (tile_row + 1) * carried_tile_height);
            for (int y = tile_row * carried_tile_height; y < end; ++y) {
                const SphereRow row = last.row_at(y);
                const NewRow now{cast.row(y), distance_m.data(), seen_.row(y)};
                const std::int32_t cap = caps[y < camera_.height / 2 ? 0 : 1];
                if (is_polar(y) && cap == mixed) {
                    for (int x = 0; x < camera_.width; ++x)
                        cast.row(y)[x] |= std::uint8_t(x % polar_step == 0 || x == camera_.width - 1);
                    continue;
                }
                if (is_polar(y))
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
    for (int from = 0, to = 0; from < tile_columns_; from = to) {
        const std::int32_t plane = planes[std::size_t(from)];
        while (to < tile_columns_ && planes[std::size_t(to)] == plane)
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
        if (!is_polar(y) || !polar_cast_[y < camera_.height / 2 ? 0 : 1])
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
    set_world(pose.orientation);
    pose_ = pose;
    movers_.assign(movers.begin(), movers.end());
    const SphereWarp here = warp_from(pose);
    const bool closes = camera_.range.closes();
    by_rows(camera_.height, [&](int y) { seen_.pad(y, closes, SurfacePlanes::none); });
    tbb::parallel_for(tbb::blocked_range<int>(0, tile_rows_), [&](const auto& range) {
        std::vector<int> columns;
        PlaneRow planes(camera_.width), planes_below(camera_.width);
        for (int tile_row = range.begin(); tile_row < range.end(); ++tile_row) {
            const int top = tile_row * carried_tile_height, end = std::min(camera_.height, top + carried_tile_height);
            for (int i = 0; i < tile_columns_; ++i)
                tile(i, tile_row) = seen_.row(top)[i * carried_tile_width];
            spread_planes(here, top, planes);
            for (int y = top; y < end; ++y) {
                const int below = std::min(y + 1, camera_.height - 1);
                spread_planes(here, below, planes_below);
                columns.clear();
                find_edges(here, {row_at(y), row_at(below), planes, planes_below}, cells_.row(y), &tile(0, tile_row),
                           columns);
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
