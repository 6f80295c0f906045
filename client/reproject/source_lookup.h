#pragma once
/// Where directions fall in a source picture, in single precision: one small class per projection, so that the hot
/// loops are compiled for each and call nothing through a pointer. Directions are in the source's camera frame.
#include "float_math.h"

#include <equistream/camera.h>

#include <array>
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

/// Whether a position lies in a picture of this size; false for NaN.
inline bool lies_inside(PixelPosition p, int width, int height) {
    constexpr float edge = edge_rounding_px;
    return p.u >= -edge && p.u <= float(width) + edge && p.v >= -edge && p.v <= float(height) + edge;
}

class EquirectLookup {
public:
    explicit EquirectLookup(const EquirectCamera& camera);

    PixelPosition project(Vec3f d) const {
        float longitude = fast_atan2(d.x, -d.z) - middle_;
        if (longitude > float(pi))
            longitude -= float(2 * pi);
        else if (longitude < -float(pi))
            longitude += float(2 * pi);
        const float latitude = fast_atan2(d.y, std::sqrt(d.x * d.x + d.z * d.z));
        return {longitude * columns_per_radian_ + half_width_, (top_ - latitude) * rows_per_radian_};
    }
    bool contains(PixelPosition p) const { return lies_inside(p, width_, height_); }
    Taps taps(PixelPosition p) const {
        const BilinearCell cell(p);
        Taps taps;
        taps.weight = cell.weight;
        for (int k = 0; k < 4; ++k) {
            taps.x[k] = cell.x + (k & 1);
            taps.y[k] = cell.y + (k >> 1);
        }
        if (cell.x < 0 || cell.y < 0 || cell.x + 1 >= width_ || cell.y + 1 >= height_)
            bring_inside(taps);
        return taps;
    }
    Vec3f unit_direction(int x, int y) const {
        const float c = cos_latitude_[y];
        return {c * sin_longitude_[x], sin_latitude_[y], -c * cos_longitude_[x]};
    }

private:
    /// Columns go round; beyond a pole the rows come back on the other side. Partial pictures repeat their edge.
    void bring_inside(Taps& taps) const;

    int width_ = 0, height_ = 0;
    float middle_ = 0, half_width_ = 0, top_ = 0, columns_per_radian_ = 0, rows_per_radian_ = 0;
    bool closes_ = false, north_pole_ = false, south_pole_ = false;
    std::vector<float> sin_longitude_, cos_longitude_, sin_latitude_, cos_latitude_;
};

class PerspectiveLookup {
public:
    explicit PerspectiveLookup(const PerspectiveCamera& camera);

    PixelPosition project(Vec3f d) const {
        const float scale = d.z < 0 ? focal_ / -d.z : std::nanf("");
        return {half_width_ + d.x * scale, half_height_ - d.y * scale};
    }
    bool contains(PixelPosition p) const { return lies_inside(p, width_, height_); }
    Taps taps(PixelPosition p) const {
        const BilinearCell cell(p);
        Taps taps;
        taps.weight = cell.weight;
        for (int k = 0; k < 4; ++k) {
            taps.x[k] = std::clamp(cell.x + (k & 1), 0, width_ - 1);
            taps.y[k] = std::clamp(cell.y + (k >> 1), 0, height_ - 1);
        }
        return taps;
    }
    Vec3f unit_direction(int x, int y) const {
        const Vec3f d{(float(x) + 0.5f - half_width_) / focal_, (half_height_ - float(y) - 0.5f) / focal_, -1};
        return d * (1 / std::sqrt(dot(d, d)));
    }

private:
    int width_ = 0, height_ = 0;
    float focal_ = 1, half_width_ = 0, half_height_ = 0;
};

}  // namespace equistream
