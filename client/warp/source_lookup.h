#pragma once
/// Where directions fall in a source picture, in single precision: one small class per projection, so that the hot
/// loops are compiled for each and call nothing through a pointer. Directions are in the source's camera frame.
#include "float_math.h"
#include "warp.h"

#include <equistream/camera.h>
#include <plugin/formulas/scalars.h>

#include <array>
#include <cmath>
#include <vector>

namespace equistream {

struct PixelPosition {
    float u = 0, v = 0;
};

/// The four samples around a position and their bilinear weights.
struct Taps {
    std::array<int, 4> x{};
    std::array<int, 4> y{};
    std::array<float, 4> weight{};
};

/// Corner samples and weights before any column or row is brought back into the picture.
struct BilinearCell {
    int x = 0, y = 0;
    std::array<float, 4> weight{};

    explicit BilinearCell(PixelPosition p) {
        const float fu = std::floor(p.u - 0.5f);
        const float fv = std::floor(p.v - 0.5f);
        const float a = p.u - 0.5f - fu;
        const float b = p.v - 0.5f - fv;
        x = static_cast<int>(fu);
        y = static_cast<int>(fv);
        weight = {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
    }
};

/// The four samples around a position, brought back into the picture.
inline Taps taps_around(const formulas::Wrapping& grid, PixelPosition p) {
    const BilinearCell cell(p);
    Taps taps;
    taps.weight = cell.weight;
    const bool inside = cell.x >= 0 && cell.y >= 0 && cell.x + 1 < grid.width && cell.y + 1 < grid.height;
    for (int k = 0; k < 4; ++k) {
        const int x = cell.x + (k & 1), y = cell.y + (k >> 1);
        taps.x[k] = inside ? x : formulas::wrapped_column(grid, x, y);
        taps.y[k] = inside ? y : formulas::wrapped_row(grid, y);
    }
    return taps;
}

inline bool lies_inside(const formulas::Wrapping& grid, PixelPosition p) {
    return formulas::is_within(p.u, float(grid.width)) && formulas::is_within(p.v, float(grid.height));
}

class EquirectLookup {
public:
    explicit EquirectLookup(const EquirectCamera& camera);

    PixelPosition project(Vec3f d) const {
        return {formulas::sphere_column(d.x, d.z, grid_.middle, grid_.columns_per_radian, grid_.half_width),
                formulas::sphere_row(d.x, d.y, d.z, grid_.top, grid_.rows_per_radian)};
    }
    bool contains(PixelPosition p) const { return lies_inside(grid_, p); }
    Taps taps(PixelPosition p) const { return taps_around(grid_, p); }
    Vec3f unit_direction(int x, int y) const {
        const float c = cos_latitude_[y];
        return {c * sin_longitude_[x], sin_latitude_[y], -c * cos_longitude_[x]};
    }

private:
    SourceGrid grid_;
    std::vector<float> sin_longitude_, cos_longitude_, sin_latitude_, cos_latitude_;
};

class PerspectiveLookup {
public:
    explicit PerspectiveLookup(const PerspectiveCamera& camera) : grid_(source_grid(camera)) {}

    PixelPosition project(Vec3f d) const {
        return {formulas::flat_column(d.x, d.z, grid_.focal_px, grid_.half_width),
                formulas::flat_row(d.y, d.z, grid_.focal_px, grid_.half_height)};
    }
    bool contains(PixelPosition p) const { return lies_inside(grid_, p); }
    Taps taps(PixelPosition p) const { return taps_around(grid_, p); }
    Vec3f unit_direction(int x, int y) const {
        const Vec3f d{(float(x) + 0.5f - grid_.half_width) / grid_.focal_px,
                      (grid_.half_height - float(y) - 0.5f) / grid_.focal_px, -1};
        return d * (1 / std::sqrt(dot(d, d)));
    }

private:
    SourceGrid grid_;
};

}  // namespace equistream
