#include "carried_tiles.h"

#include "surface_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream {

namespace {

/// Up to this turn, in radians, ways in the picture are longer than to first order by no more than this part.
constexpr float largest_turn = 0.1f, second_order = 0.25f;

}  // namespace

CarriedTiles::CarriedTiles(const EquirectCamera& camera, const SphereAngles& angles)
    : camera_(camera), angles_(angles), columns_((camera.width + carried_tile_width - 1) / carried_tile_width),
      rows_((camera.height + carried_tile_height - 1) / carried_tile_height),
      seen_(std::size_t(columns_) * std::size_t(rows_), mixed) {}

/// The inverse distance of a plane in a pixel's direction; NaN where that is not before it and outside the head box, or
/// so near that directions turn far.
float CarriedTiles::met(const SphereWarp& warp, std::int32_t plane, int x, int y) const {
    const float* p = warp.planes + 4 * std::ptrdiff_t(plane);
    const SphereRow row = angles_.row(y);
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
std::int32_t CarriedTiles::still_seen(const SphereWarp& warp, int tile_column, int tile_row) const {
    const std::int32_t plane = seen(tile_column, tile_row);
    if (plane <= SurfacePlanes::none)
        return mixed;
    const int left = tile_column * carried_tile_width, right = std::min(camera_.width, left + carried_tile_width) - 1;
    const int top = tile_row * carried_tile_height, bottom = std::min(camera_.height, top + carried_tile_height) - 1;
    float first_column = float(left), last_column = float(right), first_row = float(top), last_row = float(bottom);
    for (const int y : {top, bottom})
        for (const int x : {left, right}) {
            const float s = met(warp, plane, x, y);
            const float sin_l = angles_.sin_longitude()[x], cos_l = angles_.cos_longitude()[x];
            const float sin_p = angles_.sin_latitude(y), cos_p = angles_.cos_latitude(y);
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
                if (seen(i, j) != plane)
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
std::int32_t CarriedTiles::cap(const SphereWarp& warp, bool top) const {
    // What moves over the pole may come from any longitude.
    if (!camera_.range.closes())
        return mixed;
    constexpr int spare_rows = 2 * carried_tile_height;
    const auto from_pole = [&](int i) { return top ? i : camera_.height - 1 - i; };
    int rows = 0;
    while (rows < camera_.height && angles_.is_polar(from_pole(rows)))
        ++rows;
    if (rows == 0 || rows + spare_rows >= camera_.height)
        return mixed;
    const int first = std::min(from_pole(0), from_pole(rows + spare_rows)) / carried_tile_height;
    const int last = std::max(from_pole(0), from_pole(rows + spare_rows)) / carried_tile_height;
    const std::int32_t plane = seen(0, first);
    if (plane <= SurfacePlanes::none)
        return mixed;
    for (int j = first; j <= last; ++j)
        for (int i = 0; i < columns_; ++i)
            if (seen(i, j) != plane)
                return mixed;
    const float way_m = std::sqrt(warp.x_m * warp.x_m + warp.y_m * warp.y_m + warp.z_m * warp.z_m);
    for (const int y : {from_pole(0), from_pole(rows)})
        for (int x = 0; x < camera_.width; x += carried_tile_width)
            if (!(met(warp, plane, x, y) * way_m * warp.rows_per_rad * (1 + second_order) <= spare_rows))
                return mixed;
    return plane;
}

}  // namespace equistream
