#pragma once
/// Last frame's surfaces of a sphere found again from where the sphere is now, by rows and in whole registers (Highway
/// chooses among the machine's instruction sets at run time). Internal to depth reuse.
///
/// A pixel is held as the plane of the triangle that it saw (surface_planes.h). In a plane the inverse distance
/// s = 1/r = n.d / (c - n.o) is linear in direction d, so a pixel whose plane is known is intersected again, exactly,
/// from any position o: no error gathers from frame to frame, only which plane it is has to be found. A point at s in
/// direction d now was seen, before the sphere went the way t, in direction d + s t: there the old planes are looked
/// up, and where those of the pixels around agree within the error, the nearest is taken.
#include <algorithm>
#include <cstdint>
#include <vector>

namespace equistream {

/// A plane of values with spare columns on both sides, which repeat what lies beyond the seam.
template <typename T>
class PaddedPlane {
public:
    static constexpr int margin = 64;

    PaddedPlane(int width, int height)
        : width_(width), stride_(width + 2 * margin), values_(std::size_t(stride_) * std::size_t(height)) {}

    int stride() const { return stride_; }
    T* row(int y) { return values_.data() + std::ptrdiff_t(y) * stride_ + margin; }
    const T* row(int y) const { return values_.data() + std::ptrdiff_t(y) * stride_ + margin; }
    /// Fills a row's spare columns: from its other end where the picture closes, else with `beyond`.
    void pad(int y, bool closes, T beyond) {
        T* values = row(y);
        for (int i = 0; i < margin; ++i) {
            values[width_ + i] = closes ? values[i % width_] : beyond;
            values[-1 - i] = closes ? values[width_ - 1 - i % width_] : beyond;
        }
    }

private:
    int width_ = 0, stride_ = 0;
    std::vector<T> values_;
};

/// Which plane each pixel saw: numbers of SurfacePlanes.
using PlaneNumbers = PaddedPlane<std::int32_t>;

/// Pixels are looked at in tiles of this size first.
inline constexpr int carried_tile_width = 16, carried_tile_height = 8;
/// A tile that sees more than one plane.
inline constexpr std::int32_t mixed = -1;

/// How the planes of four neighbouring pixels go together, by the upper left of them.
enum Cell : std::uint8_t {
    agreeing = 0,  ///< all are as good, within the error
    parted = 1,    ///< one surface ends before another, or it cannot be told: to be cast
    foremost = 2,  ///< they meet in a hollow: the nearest distance counts
    hindmost = 3,  ///< they meet in a ridge: the farthest does
};
using Cells = PaddedPlane<std::uint8_t>;

/// What all rows share.
struct SphereWarp {
    const PlaneNumbers* seen;  ///< last frame
    const Cells* cells;        ///< last frame
    const float* planes;       ///< SurfacePlanes::values
    int width, height;
    float columns_per_rad, rows_per_rad;
    float from_m[3];      ///< where the planes are intersected from, in the world
    float x_m, y_m, z_m;  ///< the way from the last position to this one, in the camera's axes
    const float* sin_longitude;
    const float* cos_longitude;
    const float* column_world[3];  ///< a direction is cos_latitude x column + row, in the world
    float box_radius_m, error;     ///< B, and the largest error in w
};

struct SphereRow {
    int y;
    float sin_latitude, cos_latitude;
    float world[3];  ///< the row's part of a direction
};

/// One row of the new frame. Where the planes tell enough, sets distance and plane; else sets `cast` to 1, which where
/// it is 1 already stays so.
struct NewRow {
    std::uint8_t* cast;
    float* distance_m;
    std::int32_t* seen;
};

/// Columns from `first` to before `last`, found by looking where they were. `first` is a multiple of
/// carried_tile_width, and beyond `last` a register may be written.
void warp_columns(const SphereWarp& warp, const SphereRow& row, const NewRow& now, int first, int last);
/// The same where all is known to see one plane.
void fill_columns(const SphereWarp& warp, const SphereRow& row, const NewRow& now, int first, int last,
                  std::int32_t plane);

}  // namespace equistream
