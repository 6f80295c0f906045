#include "forward_depth.h"

#include <client/warp/eye_rays.h>

#include <equistream/bound.h>
#include <equistream/depth_agreement.h>
#include <plugin/formulas/scalars.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

namespace equistream {

namespace {

constexpr int tile_side = 8;    ///< of the map that says where gaps are
constexpr int block_side = 16;  ///< of the grid: samples that are looked at, or passed over, together

/// Which squares of the eye's picture have gaps.
class GapTiles {
public:
    GapTiles(const EyeView& eye, const Gaps& gaps)
        : columns_((eye.camera.width + tile_side - 1) / tile_side),
          rows_((eye.camera.height + tile_side - 1) / tile_side), has_gaps_(std::size_t(columns_) * rows_) {
        for (const GapSpan& span : gaps.spans())
            for (int column = span.begin / tile_side; column <= (span.end - 1) / tile_side; ++column)
                has_gaps_[std::size_t(span.y / tile_side) * columns_ + column] = 1;
    }

    /// Pixel bounds, which may lie outside the picture.
    bool any(glm::dvec2 low, glm::dvec2 high) const {
        const int left = clamped(low.x, columns_), right = clamped(high.x, columns_);
        const int top = clamped(low.y, rows_), bottom = clamped(high.y, rows_);
        if (high.x < 0 || high.y < 0 || low.x > columns_ * tile_side || low.y > rows_ * tile_side)
            return false;
        for (int row = top; row <= bottom; ++row)
            for (int column = left; column <= right; ++column)
                if (has_gaps_[std::size_t(row) * columns_ + column] != 0)
                    return true;
        return false;
    }

private:
    static int clamped(double pixel, int count) {
        return int(std::clamp(std::floor(pixel / tile_side), 0.0, double(count - 1)));
    }

    int columns_, rows_;
    std::vector<std::uint8_t> has_gaps_;
};

/// A sample in the eye's picture. `inverse` is 1 / planar depth, NaN for what is not there or not before the eye.
struct Projected {
    float u = 0, v = 0;
    float inverse = std::numeric_limits<float>::quiet_NaN();
    float distance = 0, clearance = 0;  ///< from the grid's own centre; clearance as in DepthAgreement
};

/// A block and one sample further to each side, so that surfaces do not end at a block's edge.
constexpr int patch_side = block_side + 2;
using Patch = std::array<std::array<Projected, patch_side>, patch_side>;

template <typename Grid>
class ForwardDraw {
public:
    ForwardDraw(const Grid& grid, const ForwardTask& task, const StillThere& still_there)
        : grid_(grid), eye_(task.eye), origin_(task.picture.origin.view()), tiles_(task.eye, task.gaps),
          inverse_planar_(task.seen.inverse_planar), still_there_(still_there),
          eye_from_world_(glm::mat3_cast(glm::conjugate(eye_.pose.orientation))),
          eye_from_grid_(eye_from_world_ * glm::mat3_cast(grid.pose().orientation)),
          centre_(eye_from_world_ * (grid.pose().position_m - eye_.pose.position_m)), width_(width_of(grid.camera())),
          height_(height_of(grid.camera())),
          focal_(eye_.camera.focal_px()), agreement_{float(std::max(grid.box_radius_m(), glm::length(centre_))),
                                                     float(std::sin(error_budget_rad(focal_, task.error_budget_px)))},
          wrapping_{width_, height_, columns_close(grid.camera()), false, false} {}

    void run() {
        const int rows = (height_ + block_side - 1) / block_side;
        const int columns = (width_ + block_side - 1) / block_side;
        tbb::parallel_for(tbb::blocked_range<int>(0, rows), [&](const tbb::blocked_range<int>& range) {
            for (int row = range.begin(); row < range.end(); ++row) {
                // Of a sphere that patches are of, most rows hold none.
                if (!grid_.holds_any(0, row * block_side, width_, block_side))
                    continue;
                for (int column = 0; column < columns; ++column)
                    if (grid_.holds_any(column * block_side, row * block_side, block_side, block_side) &&
                        may_show(column * block_side, row * block_side))
                        draw_block(column * block_side, row * block_side);
            }
        });
    }

private:
    /// False only if nothing of the block can fall on a gap: its points lie within a cone around the line from its
    /// middle's nearest to its farthest point.
    bool may_show(int left, int top) const {
        float nearest = std::numeric_limits<float>::infinity(), farthest = 0;
        for (int y = std::max(top - 1, 0); y < std::min(top + block_side + 1, height_); ++y)
            for (int x = std::max(left - 1, 0); x < std::min(left + block_side + 1, width_); ++x) {
                SamplePlace place;
                if (!grid_.find(x, y, place))
                    continue;
                const float depth = std::min(grid_.depth_m(place), far_distance_m);
                if (depth > 0) {
                    nearest = std::min(nearest, depth);
                    farthest = std::max(farthest, depth);
                }
            }
        if (farthest == 0)
            return false;
        const double away = glm::length(centre_);
        if (nearest <= 2 * away)
            return true;
        const glm::dvec3 middle = direction(left + 0.5 * block_side, top + 0.5 * block_side);
        double radius = 0;
        for (const int corner : {0, 1, 2, 3})
            radius = std::max(radius, glm::distance(middle, direction(left + (corner & 1 ? block_side + 1 : -1),
                                                                      top + (corner & 2 ? block_side + 1 : -1))));
        const glm::dvec3 from = glm::normalize(centre_ + double(nearest) * middle);
        const glm::dvec3 to = glm::normalize(centre_ + double(farthest) * middle);
        const glm::dvec3 axis = glm::normalize(from + to);
        const double half_angle = 1.1 * (0.5 * glm::distance(from, to) + radius * nearest / (nearest - away));
        return cone_may_show(axis, half_angle);
    }

    bool cone_may_show(const glm::dvec3& axis, double half_angle) const {
        const auto range = [&](double across, double& low, double& high) {
            // The cone's angles in the plane of `across` and forward, no wider than the cone seen past the third axis.
            const double in_plane = std::hypot(across, axis.z);
            const double sine = std::sin(std::min(half_angle, pi / 2)) / std::max(in_plane, 1e-9);
            if (sine >= 1)
                return true;
            const double middle = std::atan2(across, -axis.z), spread = std::asin(sine);
            const double limit = pi / 2 - 1e-3;
            if (middle - spread >= limit || middle + spread <= -limit)
                return false;
            low = focal_ * std::tan(std::max(middle - spread, -limit));
            high = focal_ * std::tan(std::min(middle + spread, limit));
            return true;
        };
        const double wide = 1e9;
        glm::dvec2 low(-wide), high(wide);
        if (!range(axis.x, low.x, high.x) || !range(-axis.y, low.y, high.y))
            return false;
        const glm::dvec2 centre(0.5 * eye_.camera.width, 0.5 * eye_.camera.height);
        return tiles_.any(centre + low - 1.0, centre + high + 1.0);
    }

    glm::dvec3 direction(double u, double v) const { return eye_from_grid_ * direction_of(grid_.camera(), u, v); }

    Projected project(int x, int y) const {
        Projected out;
        x = formulas::column_round(wrapping_, x);
        SamplePlace place;
        if (x < 0 || y < 0 || x >= width_ || y >= height_ || !grid_.find(x, y, place))
            return out;
        const float depth = grid_.depth_m(place);
        if (!(depth > 0))
            return out;
        const double distance = std::min(depth, far_distance_m);
        const glm::dvec3 point = centre_ + distance * direction(x + 0.5, y + 0.5);
        if (still_there_ && !still_there_(eye_.pose.position_m + eye_.pose.orientation * point))
            return out;
        out = project_point(point);
        out.distance = float(distance);
        out.clearance = agreement_.clearance(depth);
        return out;
    }

    /// Of a point in the eye's frame.
    Projected project_point(const glm::dvec3& point) const {
        Projected out;
        if (!(-point.z > 0))
            return out;
        out.u = float(0.5 * eye_.camera.width - focal_ * point.x / point.z);
        out.v = float(0.5 * eye_.camera.height + focal_ * point.y / point.z);
        out.inverse = float(-1 / point.z);
        return out;
    }

    void draw_block(int left, int top) {
        Patch patch;
        for (int j = 0; j < patch_side; ++j)
            for (int i = 0; i < patch_side; ++i)
                patch[j][i] = project(left + i - 1, top + j - 1);
        // whole[j][i]: the cell to the right of and below sample (i, j) is one surface, both its triangles.
        std::array<std::array<bool, patch_side>, patch_side> whole{};
        for (int j = 0; j <= block_side; ++j)
            for (int i = 0; i <= block_side; ++i)
                whole[j][i] = draw_cell(patch, i, j);
        for (int j = 1; j <= block_side; ++j)
            for (int i = 1; i <= block_side; ++i)
                if (!std::isnan(patch[j][i].inverse) &&
                    !(whole[j][i] && whole[j][i - 1] && whole[j - 1][i] && whole[j - 1][i - 1]))
                    draw_footprint(left + i - 1, top + j - 1, patch[j][i]);
    }

    bool draw_cell(const Patch& patch, int i, int j) {
        const bool right = joined(patch, {i, j}, {i + 1, j}), below = joined(patch, {i, j}, {i, j + 1});
        const bool far_right = joined(patch, {i + 1, j}, {i + 1, j + 1});
        const bool far_below = joined(patch, {i, j + 1}, {i + 1, j + 1});
        // Cells of the first row and column are drawn by the block before.
        const bool own = i > 0 && j > 0;
        if (own && right && far_right)
            draw_triangle(patch[j][i], patch[j][i + 1], patch[j + 1][i + 1], 1);
        if (own && below && far_below)
            draw_triangle(patch[j][i], patch[j + 1][i + 1], patch[j + 1][i], 1);
        return right && far_right && below && far_below;
    }

    /// What may belong to the sample: as far as its neighbours, at its own distance.
    void draw_footprint(int x, int y, const Projected& sample) {
        std::array<Projected, 4> corners;
        for (int k = 0; k < 4; ++k)
            corners[k] = project_point(centre_ + double(sample.distance) *
                                                     direction(x - 0.5 + 2 * (k % 2), y - 0.5 + 2 * (k / 2)));
        // A corner that is not before the eye has no place in its picture.
        if (std::ranges::any_of(corners, [](const Projected& corner) { return std::isnan(corner.inverse); }))
            return;
        draw_triangle(corners[0], corners[1], corners[3], -1);
        draw_triangle(corners[0], corners[3], corners[2], -1);
    }

    /// Neighbours of one surface: equal within the bound, or on a line with the sample before or after.
    bool joined(const Patch& patch, glm::ivec2 a, glm::ivec2 b) const {
        const Projected &p = at(patch, a), &q = at(patch, b);
        if (std::isnan(p.inverse) || std::isnan(q.inverse))
            return false;
        if (agreement_.same(p.clearance, q.clearance))
            return true;
        const glm::ivec2 step = b - a;
        return continues(patch, a - step, p, q) || continues(patch, b + step, q, p);
    }

    /// Whether w goes on from the sample `before` through `p` to `q`.
    bool continues(const Patch& patch, glm::ivec2 before, const Projected& p, const Projected& q) const {
        if (before.x < 0 || before.y < 0 || before.x >= patch_side || before.y >= patch_side)
            return false;
        const Projected& o = at(patch, before);
        if (std::isnan(o.inverse))
            return false;
        return formulas::continues_line(o.clearance, p.clearance, q.clearance, agreement_.box_radius_m,
                                        agreement_.tolerance);
    }

    static const Projected& at(const Patch& patch, glm::ivec2 p) { return patch[p.y][p.x]; }

    /// `sign`: 1, or -1 for a footprint.
    void draw_triangle(const Projected& a, const Projected& b, const Projected& c, float sign) {
        const float low_u = std::min({a.u, b.u, c.u}), high_u = std::max({a.u, b.u, c.u});
        const float low_v = std::min({a.v, b.v, c.v}), high_v = std::max({a.v, b.v, c.v});
        const float width = float(eye_.camera.width), height = float(eye_.camera.height);
        if (!(high_u > 0 && high_v > 0 && low_u < width && low_v < height))
            return;
        const float area = (b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v);
        if (area == 0)
            return;
        const int left = int(std::ceil(std::max(low_u - 0.5f, 0.0f))), right = int(std::min(high_u - 0.5f, width - 1));
        const int top = int(std::ceil(std::max(low_v - 0.5f, 0.0f))), bottom = int(std::min(high_v - 0.5f, height - 1));
        for (int y = top; y <= bottom; ++y)
            for (int x = left; x <= right; ++x) {
                const float u = float(x) + 0.5f - a.u, v = float(y) + 0.5f - a.v;
                const float q = (u * (c.v - a.v) - v * (c.u - a.u)) / area;
                const float r = (v * (b.u - a.u) - u * (b.v - a.v)) / area;
                if (q >= 0 && r >= 0 && q + r <= 1)
                    draw_pixel(x, y, sign * (a.inverse + q * (b.inverse - a.inverse) + r * (c.inverse - a.inverse)));
            }
    }

    /// The largest key stays: of surfaces the nearest; where there is none, of mere footprints, whose keys are
    /// negative, the farthest, because what is in front would else grow into the background that it uncovered.
    void draw_pixel(int x, int y, float key) {
        if (origin_.pixel(x, y)[0] != std::uint8_t(PixelOrigin::gap))
            return;
        std::atomic_ref<float> stored(inverse_planar_.pixel(x, y)[0]);
        float before = stored.load(std::memory_order_relaxed);
        while (!(before >= key) && !stored.compare_exchange_weak(before, key, std::memory_order_relaxed)) {
        }
    }

    const Grid& grid_;
    const EyeView& eye_;
    ImageView<const std::uint8_t> origin_;
    GapTiles tiles_;
    FloatImage& inverse_planar_;
    const StillThere& still_there_;
    glm::dmat3 eye_from_world_, eye_from_grid_;
    glm::dvec3 centre_;  ///< of the grid, in the eye's frame
    int width_, height_;
    double focal_;
    DepthAgreement agreement_;
    formulas::Wrapping wrapping_;
};

}  // namespace

void draw_forward(const PictureGrid& grid, const ForwardTask& task, const StillThere& still_there) {
    ForwardDraw(grid, task, still_there).run();
}

void end_drawing(const ForwardTask& task) {
    for (const GapSpan& span : task.gaps.spans())
        for (int x = span.begin; x < span.end; ++x) {
            float& inverse = *task.seen.inverse_planar.pixel(x, span.y);
            inverse = std::abs(inverse);
        }
}

void draw_forward(const PatchGrid& grid, const ForwardTask& task) {
    ForwardDraw(grid, task, {}).run();
}

}  // namespace equistream
