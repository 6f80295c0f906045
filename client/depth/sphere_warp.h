#pragma once
/// Last frame's depth of a sphere carried to where the sphere is now, by rows and in whole registers (Highway chooses
/// among the machine's instruction sets at run time). Internal to depth reuse.
///
/// Depth is held as inverse distance s = 1/r: along a plane it is linear in direction, so between pixels of one surface
/// it may be interpolated. With t the way the sphere went, a point at s' in direction d' now was seen at
/// d' + s' t, whose distance R gives s' = s / (sqrt(1 - s^2 |t_across|^2) - s t.d'): a fixed point, found in two steps.
#include <cstdint>
#include <vector>

namespace equistream {

/// A plane of floats with spare columns on both sides, which repeat what lies beyond the seam.
class PaddedPlane {
public:
    static constexpr int margin = 64;

    PaddedPlane() = default;
    PaddedPlane(int width, int height)
        : width_(width), stride_(width + 2 * margin), values_(std::size_t(stride_) * std::size_t(height)) {}

    int stride() const { return stride_; }
    float* row(int y) { return values_.data() + std::ptrdiff_t(y) * stride_ + margin; }
    const float* row(int y) const { return values_.data() + std::ptrdiff_t(y) * stride_ + margin; }
    /// Fills a row's spare columns: from its other end where the picture closes, else with `beyond`.
    void pad(int y, bool closes, float beyond);

private:
    int width_ = 0, stride_ = 0;
    std::vector<float> values_;
};

/// What all rows share.
struct SphereWarp {
    const PaddedPlane* inverse_m;  ///< last frame: 1 / distance, 0 for a miss
    const PaddedPlane* cost;       ///< last frame, by cell: error in w so far and that of interpolating in it
    int width, height;
    float columns_per_rad, rows_per_rad;
    float x_m, y_m, z_m;  ///< the way from the last position to this one, in the camera's axes
    const float* sin_longitude;
    const float* cos_longitude;
    float box_radius_m, error;  ///< B, and the largest error in w
};

/// One row of the new frame. Where `cast` is 0 on entry and the old frame tells enough, sets distance, inverse distance
/// and error; else sets `cast` to 1.
struct SphereRow {
    int y;
    float sin_latitude, cos_latitude;
    std::uint8_t* cast;
    float* distance_m;
    float* inverse_m;
    float* error;
};

void warp_row(const SphereWarp& warp, const SphereRow& row);

/// The cell between the centres of a pixel, its right, its lower and its lower right neighbour, where an edge of depth
/// runs through it.
struct EdgeCell {
    int x;
    float lowest_inverse_m, highest_inverse_m;  ///< of its corners
};

/// Adds to `cost` what interpolating may cost in each cell whose upper left pixel is in row `y` (from second
/// differences of w), and lists the cells where that alone is more than `error`: their cost is infinite. Spare columns
/// of the row and the one below are filled.
void add_interpolation_cost(const PaddedPlane& inverse_m, int y, const SphereWarp& bounds, float* cost,
                            std::vector<EdgeCell>& edges);

}  // namespace equistream
