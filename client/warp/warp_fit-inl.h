// Positions of whole tiles from a few of their points, where that is good enough.
#if defined(EQUISTREAM_WARP_FIT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_WARP_FIT_INL_H
#undef EQUISTREAM_WARP_FIT_INL_H
#else
#define EQUISTREAM_WARP_FIT_INL_H
#endif

#include "warp_positions-inl.h"

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// 1 / planar depth as a plane has it: linear in the pixel from the tile's first one.
struct InversePlane {
    float first = 0, per_column = 0, per_row = 0;
};

/// Points of a patch, -1 to 1 across and down: three by three that a quadratic goes through, then seven where a cubic
/// strays farthest from that.
inline constexpr int fit_points = 16;
alignas(64) inline constexpr float fit_across[fit_points] = {-1, 0,      1,     -1,     0,     1,      -1,    0,
                                                             1,  -.577f, .577f, -.577f, .577f, -.577f, .577f, 1};
alignas(64) inline constexpr float fit_down[fit_points] = {-1, -1, -1, 0, 0, 0,     1,      1,
                                                           1,  -1, -1, 1, 1, .577f, -.577f, .577f};

/// The biquadratic through nine values of a patch; [i][j] belongs to the i-th power across and the j-th down.
class Quadratic {
public:
    explicit Quadratic(const float* values) {
        float across[3][3];  // by row of points
        for (int row = 0; row < 3; ++row) {
            const float* v = values + 3 * row;
            across[row][0] = v[1];
            across[row][1] = 0.5f * (v[2] - v[0]);
            across[row][2] = 0.5f * (v[2] + v[0]) - v[1];
        }
        for (int i = 0; i < 3; ++i) {
            c_[i][0] = across[1][i];
            c_[i][1] = 0.5f * (across[2][i] - across[0][i]);
            c_[i][2] = 0.5f * (across[2][i] + across[0][i]) - across[1][i];
        }
    }
    /// Of the i-th power across, at some heights.
    HWY_INLINE Floats coefficient(int i, Floats down) const {
        return hn::MulAdd(hn::MulAdd(all(c_[i][2]), down, all(c_[i][1])), down, all(c_[i][0]));
    }
    HWY_INLINE Floats at(Floats across, Floats down) const {
        return hn::MulAdd(hn::MulAdd(coefficient(2, down), across, coefficient(1, down)), across, coefficient(0, down));
    }

private:
    float c_[3][3];
};

/// A quadratic laid out for a patch's rows.
class RowCurves {
public:
    HWY_INLINE void lay_out(const Quadratic& quadratic) {
        for (int row = 0; row < tile_height; row += lanes)
            for (int i = 0; i < 3; ++i)
                hn::Store(quadratic.coefficient(i, hn::MulAdd(hn::Iota(float_tag, float(row)),
                                                              all(2.0f / (tile_height - 1)), all(-1.0f))),
                          float_tag, c_[i] + row);
    }
    HWY_INLINE Floats at(int row, Floats across) const {
        return hn::MulAdd(hn::MulAdd(all(c_[2][row]), across, all(c_[1][row])), across, all(c_[0][row]));
    }

private:
    alignas(64) float c_[3][tile_width];
};

/// Some tiles side by side, their pixels' points in one plane or at infinity.
class PatchFit {
public:
    /// `columns` from `x` on, tile_height rows from `y` on. False where positions would be off by more than `error`
    /// samples, or come near the source's edges.
    HWY_INLINE bool fit(const WarpJob& job, int x, int y, int columns, const InversePlane& plane, float error) {
        alignas(64) float u[fit_points], v[fit_points], length[fit_points];
        const float half_width = 0.5f * float(columns - 1);
        x_ = x;
        step_ = 1 / half_width;
        const glm::vec3 eye = job.rays.eye();
        FloatMask clear = all(0.0f) == all(0.0f);
        for (int i = 0; i < fit_points; i += lanes) {
            const Floats column = hn::MulAdd(hn::Load(float_tag, fit_across + i), all(half_width), all(half_width));
            const Floats row = hn::MulAdd(hn::Load(float_tag, fit_down + i), all(half_height), all(half_height));
            const Floats inverse =
                hn::MulAdd(column, all(plane.per_column), hn::MulAdd(row, all(plane.per_row), all(plane.first)));
            const Vectors r = ray(job.rays, column + all(float(x)), row + all(float(y)));
            const Vectors d{hn::MulAdd(all(eye.x), inverse, r.x), hn::MulAdd(all(eye.y), inverse, r.y),
                            hn::MulAdd(all(eye.z), inverse, r.z)};
            const Positions p = project(job.grid, d);
            clear = hn::And(clear, hn::And(is_clear(p.u, job.grid.width), is_clear(p.v, job.grid.height)));
            hn::Store(scaled(p.u), float_tag, u + i);
            hn::Store(scaled(p.v), float_tag, v + i);
            hn::Store(hn::Sqrt(dot(d, d)), float_tag, length + i);
        }
        if (!hn::AllTrue(float_tag, clear))
            return false;
        const Quadratic of_u(u), of_v(v);
        if (!follows(of_u, u, error) || !follows(of_v, v, error))
            return false;
        u_.lay_out(of_u);
        v_.lay_out(of_v);
        length_.lay_out(Quadratic(length));
        return true;
    }
    /// What the others take for the columns of the picture from one on.
    HWY_INLINE Floats across_from(int x) const { return hn::MulAdd(columns_from(x - x_), all(step_), all(-1.0f)); }
    /// Positions in 1/128 of a sample from the first one's middle, and lengths of directions as of SeenPoints.
    HWY_INLINE Ints u(int row, Floats across) const { return hn::NearestInt(u_.at(row, across)); }
    HWY_INLINE Ints v(int row, Floats across) const { return hn::NearestInt(v_.at(row, across)); }
    HWY_INLINE Floats length(int row, Floats across) const { return length_.at(row, across); }

private:
    static HWY_INLINE Floats scaled(Floats position) {
        return hn::MulAdd(position, all(float(position_one)), all(-0.5f * position_one));
    }
    static HWY_INLINE FloatMask is_clear(Floats position, int size) {
        return hn::And(position >= all(float(edge_samples)), position <= all(float(size - edge_samples)));
    }
    /// Whether the other points lie on it too. They do not catch a cubic's very worst, so two thirds are allowed.
    static HWY_INLINE bool follows(const Quadratic& quadratic, const float* values, float error) {
        FloatMask good = all(0.0f) == all(0.0f);
        for (int i = 0; i < fit_points; i += lanes) {
            const Floats fitted = quadratic.at(hn::Load(float_tag, fit_across + i), hn::Load(float_tag, fit_down + i));
            const Floats off = hn::Abs(fitted - hn::Load(float_tag, values + i));
            good = hn::And(good, off <= all(error * position_one * (2 / 3.0f)));
        }
        return hn::AllTrue(float_tag, good);
    }

    static constexpr float half_height = 0.5f * (tile_height - 1);
    /// All samples of all planes, chroma and what is read beside them included, lie inside the source from here on.
    static constexpr int edge_samples = 6;

    int x_ = 0;
    float step_ = 0;
    RowCurves u_, v_, length_;
};

/// Pixels' directions alone, along rows of tiles: a fit for several tiles at once where that is good enough, as it
/// mostly is, for an eye's pixels are fine beside what a cubic would add.
class DirectionFits {
public:
    explicit DirectionFits(const WarpJob& job) : job_(job) {}

    /// False where that has to be done exactly.
    HWY_INLINE bool map(Tile& tile) {
        if (tile.y != y_ || tile.x / patch_width != patch_) {
            y_ = tile.y;
            patch_ = tile.x / patch_width;
            good_ = fit(patch_ * patch_width, patch_width, wide_);
        }
        if (good_)
            lay_out(wide_, tile);
        else if (PatchFit narrow; fit(tile.x, tile_width, narrow))
            lay_out(narrow, tile);
        else
            return false;
        return tile.regular = true;
    }

private:
    static constexpr int patch_width = 4 * tile_width;

    HWY_NOINLINE bool fit(int x, int columns, PatchFit& fit) const {
        return fit.fit(job_, x, y_, columns, {}, job_.interpolation);
    }
    static HWY_INLINE void lay_out(const PatchFit& fit, Tile& tile) {
        for (int row = 0; row < tile_height; ++row)
            for (int i = 0; i < tile_width; i += lanes) {
                const Floats across = fit.across_from(tile.x + i);
                hn::Store(fit.u(row, across), int_tag, tile.u + row * tile_width + i);
                hn::Store(fit.v(row, across), int_tag, tile.v + row * tile_width + i);
            }
    }

    const WarpJob& job_;
    int y_ = -1, patch_ = -1;
    bool good_ = false;
    PatchFit wide_;
};

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
