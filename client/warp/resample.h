#pragma once
/// The ways an eye's pixel finds its colour in a source, from directions to samples.
#include "eye_rays.h"
#include "view.h"

#include <equistream/camera.h>
#include <equistream/depth_agreement.h>

#include <plugin/formulas/scalars.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace equistream {

// The two ways an eye's pixel finds its colour in a source; engines and fill passes are made of them.

struct ResampleOptions {
    double tolerance_rad = 0;                ///< e of the bound, for resample_by_surface
    PixelOrigin mark = PixelOrigin::source;  ///< what the pixels coloured here are marked with
    bool only_gaps = false;                  ///< leave alone what already has a colour
    /// For resample_by_surface: false colours every point whose direction the source has, whatever the source saw
    /// there; its depth is not read.
    bool only_seen = true;
};

/// By direction alone: positions and depth are ignored. Returns the number of pixels coloured.
std::int64_t resample_by_direction(const SourceView& source, const EyeView& eye, const ResampleOptions& options,
                                   EyePicture& picture);

/// By the point that the eye sees, where the source saw it too. Both views need depth.
std::int64_t resample_by_surface(const SourceView& source, const EyeView& eye, const ResampleOptions& options,
                                 EyePicture& picture);

// The inner loops of looking up, by tiles of pixels, for every instruction set that Highway compiles them
// for; the one that this processor has is picked when they run. Plain values and pointers only: what is here is
// compiled once, the loops many times.

inline constexpr int tile_width = 16, tile_height = 8;
inline constexpr int tile_pixels = tile_width * tile_height;

/// Positions in the source are in 1/128 of a sample; weights of samples add up to that.
inline constexpr int position_bits = 7;
inline constexpr int position_one = 1 << position_bits;

/// Below this share of the four samples' weight what is left lies too far to one side of the point to stand for it.
inline constexpr float min_weight = 0.1f;

/// Where directions fall among a source's samples, and what lies beyond its edges.
struct SourceGrid : formulas::Wrapping {
    SourceGrid() : formulas::Wrapping{} {}

    bool sphere = true;
    float half_width = 0, half_height = 0;
    float middle = 0, top = 0;                          ///< sphere: longitude and latitude, radians
    float columns_per_radian = 0, rows_per_radian = 0;  ///< sphere
    float focal_px = 1;                                 ///< perspective
};

SourceGrid source_grid(const Camera& camera);

struct Sample {
    int x = 0, y = 0;
};

/// The sample that stands for one up to two beyond the edges.
inline Sample wrapped(const formulas::Wrapping& grid, int x, int y) {
    return {formulas::wrapped_column(grid, x, y), formulas::wrapped_row(grid, y)};
}

/// One eye to be coloured from one source.
struct WarpJob {
    SourceGrid grid;
    const SourceView& source;
    const EyeView& eye;
    EyeRays rays;
    bool surface = false;      ///< by the point that the eye sees; else by direction alone
    bool only_seen = true;     ///< by the point: only where the source saw that point
    DepthAgreement agreement;  ///< by the point
    float interpolation = 0;   ///< by how much interpolated positions may be off, samples
    float radians_per_sample = 1;
    PixelOrigin mark = PixelOrigin::source;
    bool only_gaps = false;
    ImageView<std::uint8_t> rgba, origin;
};

/// Rows of tiles from `first` to before `last`; returns how many pixels were coloured. Any number of threads, each its
/// own rows.
std::int64_t warp_tiles(const WarpJob& job, int first, int last);

// Where a smooth surface of the source's hides a point though one of the samples around lies at the point's depth.
//
// On a surface that runs steeply through four samples their depths spread so far that one of them often agrees by
// chance with a point behind it. Samples alone do not tell: w = B / (r - B) of a smooth surface is known between them
// too. Where the sixteen samples around a position bend little, in all second differences (along every row and column,
// and across the inner four), bilinear w is off by at most k s(1 - s) along an axis, s being the fraction between the
// inner samples and k the sum of both second differences there: so much where the surface has one crease between them,
// a quarter of it where it is round. A point whose w is smaller by more than that, along both axes, and min_behind
// budgets is hidden. Steps, edges and what is unknown bend more and say nothing; a point before the surface cannot be
// hidden by it.

using formulas::max_bend;
using formulas::min_behind;

/// Of sixteen samples around a position, row by row, the inner four around it. `over_clearance`: 1 / (r - B) of each, w
/// over B, NaN where nothing is known; `s` and `t` in [0, 1) between the inner columns and rows.
bool surface_hides(const DepthAgreement& agreement, const std::array<float, 16>& over_clearance, float s, float t,
                   float point_over_clearance);

/// The same of a point at a position of a source; `u` and `v` in 1/128 of a sample from the centre of its first.
bool surface_hides(const DepthAgreement& agreement, const SourceGrid& grid, const ImageView<const float>& depth_m,
                   int u, int v, float point_over_clearance);

// Where directions fall in a source picture, in single precision. Directions are in the source's camera frame.

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

/// What directions of a camera's lattice are made of, by column and row, from -1 to W and H. Sphere: sine and cosine of
/// longitude and latitude. Perspective: the direction with z = -1 has x = column_a, y = row_a; the others are empty.
struct LatticeAngles {
    explicit LatticeAngles(const Camera& camera);

    std::vector<float> column_a, column_b, row_a, row_b;
};

class SourceLookup {
public:
    explicit SourceLookup(const Camera& camera) : grid_(source_grid(camera)), angles_(camera) {}

    const SourceGrid& grid() const { return grid_; }
    PixelPosition project(glm::vec3 d) const {
        if (grid_.sphere)
            return {formulas::sphere_column(d.x, d.z, grid_.middle, grid_.columns_per_radian, grid_.half_width),
                    formulas::sphere_row(d.x, d.y, d.z, grid_.top, grid_.rows_per_radian)};
        return {formulas::flat_column(d.x, d.z, grid_.focal_px, grid_.half_width),
                formulas::flat_row(d.y, d.z, grid_.focal_px, grid_.half_height)};
    }
    bool contains(PixelPosition p) const {
        return formulas::is_within(p.u, float(grid_.width)) && formulas::is_within(p.v, float(grid_.height));
    }
    /// The four samples around a position, brought back into the picture.
    Taps taps(PixelPosition p) const {
        const BilinearCell cell(p);
        Taps taps;
        taps.weight = cell.weight;
        const bool inside = cell.x >= 0 && cell.y >= 0 && cell.x + 1 < grid_.width && cell.y + 1 < grid_.height;
        for (int k = 0; k < 4; ++k) {
            const int x = cell.x + (k & 1), y = cell.y + (k >> 1);
            taps.x[k] = inside ? x : formulas::wrapped_column(grid_, x, y);
            taps.y[k] = inside ? y : formulas::wrapped_row(grid_, y);
        }
        return taps;
    }
    glm::vec3 unit_direction(int x, int y) const {
        if (grid_.sphere) {
            const float c = angles_.row_b[y + 1];
            return {c * angles_.column_a[x + 1], angles_.row_a[y + 1], -c * angles_.column_b[x + 1]};
        }
        const glm::vec3 d{(float(x) + 0.5f - grid_.half_width) / grid_.focal_px,
                          (grid_.half_height - float(y) - 0.5f) / grid_.focal_px, -1};
        return d * (1 / std::sqrt(dot(d, d)));
    }

private:
    SourceGrid grid_;
    LatticeAngles angles_;
};

// Where fill passes take colours from, as samples on the pixel grid of a camera: here every pixel of a picture, in
// gap_resample.h the blocks of a sphere that an atlas of patches holds.

/// Colour of one sample, 0 to 255.
inline glm::vec3 sample_colour(ImageView<const std::uint8_t> rgb, const YuvView& yuv, int x, int y) {
    if (rgb.data != nullptr) {
        const std::uint8_t* sample = rgb.pixel(x, y);
        return {float(sample[0]), float(sample[1]), float(sample[2])};
    }
    const yuv_to_rgb::Rgb sample = yuv_to_rgb::rgb_at(yuv, x, y);
    return {float(sample[0]), float(sample[1]), float(sample[2])};
}

/// Pixels of its picture that a grid's samples lie in.
struct SamplePlace {
    int x = 0, y = 0;
};

class PictureGrid {
public:
    explicit PictureGrid(const SourceView& view) : view_(view) {}

    const SourceView& view() const { return view_; }
    const Camera& camera() const { return view_.camera; }
    const Pose& pose() const { return view_.pose; }
    double box_radius_m() const { return view_.box_radius_m; }
    /// Of the sample at column x and row y of the camera; false where the picture does not hold it.
    bool find(int x, int y, SamplePlace& place) const {
        place = {x, y};
        return true;
    }
    float depth_m(SamplePlace p) const { return view_.depth_m.pixel(p.x, p.y)[0]; }
    glm::vec3 colour(SamplePlace p) const { return sample_colour(view_.rgb, view_.yuv, p.x, p.y); }
    /// Whether a rectangle of samples may hold any.
    bool holds_any(int, int, int, int) const { return true; }

private:
    const SourceView& view_;
};

}  // namespace equistream
