#include "source_lattice.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace equistream {

SourceLattice::SourceLattice(const Camera& camera, ImageView<const float> depth_m)
    : depth_m_(depth_m), grid_(source_grid(camera)), angles_(camera) {
    const int w = depth_m.width, h = depth_m.height;
    constexpr int side = LatticeBlock::side;
    block_columns_ = (w - first_column() + side - 1) / side;
    block_rows_ = (h + 1 + side - 1) / side;
    summaries_.resize(std::size_t(block_columns_) * std::size_t(block_rows_));
    tbb::parallel_for(0, block_rows_, [&](int block_y) {
        for (int block_x = 0; block_x < block_columns_; ++block_x)
            summaries_[std::size_t(block_y) * std::size_t(block_columns_) + std::size_t(block_x)] =
                summarise(block_x, block_y);
    });
}

void SourceLattice::wrap(int& x, int& y) const {
    x = formulas::column_round(grid_, formulas::column_over_pole(grid_, x, y));
    // A block may be wider than the whole picture.
    if (closes() && x >= width())
        x %= width();
    y = formulas::row_over_pole(grid_, y);
}

glm::vec3 SourceLattice::direction_of_tables(int column, int row) const {
    const float a = angles_.column_a[column + 1], p = angles_.row_a[row + 1];
    if (!grid_.sphere) {
        const float scale = 1 / std::sqrt(1 + a * a + p * p);
        return {a * scale, p * scale, -scale};
    }
    const float c = angles_.row_b[row + 1];
    return {c * a, p, -c * angles_.column_b[column + 1]};
}

glm::vec3 SourceLattice::direction(int x, int y) const {
    wrap(x, y);
    return direction_of_tables(std::clamp(x, -1, width()), std::clamp(y, -1, height()));
}

/// On the picture's edge, half a pixel beyond a sample: where its plane leads. Where that is another surface's, the
/// colour lookup refuses it.
float SourceLattice::edge_inverse(int x, int y) const {
    const int inner_x = std::clamp(x, 0, width() - 1), inner_y = std::clamp(y, 0, height() - 1);
    const int behind_x = std::clamp(2 * inner_x - x, 0, width() - 1);
    const int behind_y = std::clamp(2 * inner_y - y, 0, height() - 1);
    const float k = inverse_of(depth_m_.pixel(inner_x, inner_y)[0]);
    const float behind = inverse_of(depth_m_.pixel(behind_x, behind_y)[0]);
    return std::max(1.5f * k - 0.5f * behind, 0.0f);
}

LatticePoint SourceLattice::point(int x, int y) const {
    wrap(x, y);
    const bool inside = x >= 0 && y >= 0 && x < width() && y < height();
    if (inside)
        return {direction_of_tables(x, y), inverse_of(depth_m_.pixel(x, y)[0])};
    const bool on_edge = x >= -1 && y >= -1 && x <= width() && y <= height();
    const glm::vec3 q = direction_of_tables(std::clamp(x, -1, width()), std::clamp(y, -1, height()));
    return {q, on_edge ? edge_inverse(x, y) : std::nanf("")};
}

void SourceLattice::load(int block_x, int block_y, LatticeBlock& block) const {
    constexpr int before = LatticeBlock::before, after = LatticeBlock::after;
    constexpr int stride = LatticeBlock::stride, side = LatticeBlock::side;
    block.x0 = first_column() + block_x * side;
    block.y0 = first_row() + block_y * side;
    block.columns = std::min(side, width() - block.x0);
    block.rows = std::min(side, height() - block.y0);
    const bool columns_inside = block.x0 >= before && block.x0 + side + after <= width();
    for (int y = -before; y < side + after; ++y) {
        const int row = block.y0 + y;
        const int first = LatticeBlock::at(-before, y);
        if (!columns_inside || row < 0 || row >= height()) {
            for (int x = -before; x < side + after; ++x) {
                const LatticePoint p = point(block.x0 + x, row);
                const int i = LatticeBlock::at(x, y);
                block.qx[i] = p.q.x;
                block.qy[i] = p.q.y;
                block.qz[i] = p.q.z;
                block.k[i] = p.k;
            }
            continue;
        }
        const float* depth = depth_m_.row(row) + block.x0 - before;
        const float* a = &angles_.column_a[block.x0 - before + 1];
        const float p = angles_.row_a[row + 1];
        float* qx = &block.qx[first];
        float* qy = &block.qy[first];
        float* qz = &block.qz[first];
        float* k = &block.k[first];
        if (grid_.sphere) {
            const float* b = &angles_.column_b[block.x0 - before + 1];
            const float c = angles_.row_b[row + 1];
            for (int i = 0; i < stride; ++i) {
                qx[i] = c * a[i];
                qy[i] = p;
                qz[i] = -c * b[i];
            }
        } else {
            for (int i = 0; i < stride; ++i) {
                const float scale = 1 / std::sqrt(1 + a[i] * a[i] + p * p);
                qx[i] = a[i] * scale;
                qy[i] = p * scale;
                qz[i] = -scale;
            }
        }
        const float nan = std::numeric_limits<float>::quiet_NaN();
        for (int i = 0; i < stride; ++i)
            k[i] = depth[i] > 0 ? 1 / depth[i] : nan;
    }
}

void find_joined(const LatticeBlock& block, const DepthAgreement& same_surface, JoinedPoints& joined) {
    constexpr int stride = LatticeBlock::stride, count = stride * stride;
    const DepthAgreement same = same_surface;
    const float* k = block.k.data();
    // Of points beyond those that are wanted too, across the ends of rows: loops without a branch are vector code.
    for (int i = 1; i < count - 2; ++i)
        joined.right[i] = same.connected(k[i - 1], k[i], k[i + 1], k[i + 2]);
    for (int i = stride; i < count - 2 * stride; ++i)
        joined.down[i] = same.connected(k[i - stride], k[i], k[i + stride], k[i + 2 * stride]);
}

SourceLattice::Summary SourceLattice::summarise(int block_x, int block_y) const {
    constexpr int side = LatticeBlock::side;
    const int x0 = first_column() + block_x * side, y0 = first_row() + block_y * side;
    const int x1 = std::min(x0 + side, width()), y1 = std::min(y0 + side, height());
    const float infinity = std::numeric_limits<float>::infinity();
    // Beyond the picture's own samples, where the lattice has a point.
    const auto is_edge = [&](int x, int y) {
        const bool is_beyond = x < -1 || y < -1 || x > width() || y > height();
        return (x < 0 || x >= width() || y < 0 || y >= height()) && (!is_beyond || is_sample(x, y));
    };
    float nearest_m = infinity, farthest_m = 0;
    // With those beside it, since what its cells lead on by may be a step to one of them.
    for (int y = std::max(y0 - 1, 0); y <= std::min(y1 + 1, height() - 1); ++y) {
        const float* row = depth_m_.row(y);
        const int begin = std::max(x0 - 1, 0), end = std::min(x1 + 2, width());
        for (int x = begin; x < end; ++x) {
            const float r = row[x] > 0 ? row[x] : infinity;
            nearest_m = std::min(nearest_m, r);
            farthest_m = std::max(farthest_m, r);
        }
    }
    // Cells that go round the seam or over a pole end on points that lie elsewhere in the picture, or on its edge.
    if (x0 <= 0 || x1 + 1 >= width() || y0 <= 0 || y1 + 1 >= height())
        for (int y = y0 - 1; y <= y1 + 1; ++y)
            for (int x = x0 - 1; x <= x1 + 1; ++x)
                if (is_edge(x, y)) {
                    const float k = point(x, y).k;
                    nearest_m = k > 0 ? std::min(nearest_m, 1 / k) : nearest_m;
                    farthest_m = k > 0 ? std::max(farthest_m, 1 / k) : infinity;
                }
    const float nearest_k = 1 / nearest_m, farthest_k = farthest_m > 0 ? 1 / farthest_m : 0;
    // Where cells are cut, their parts lead on by half a pixel each way: by half a step between samples, twice.
    const float beyond = std::max(nearest_k - farthest_k, 0.0f);
    Summary summary{.nearest_inverse_m = nearest_k + beyond,
                    .farthest_inverse_m = std::max(farthest_k - beyond, 0.0f),
                    .axis = direction((x0 + x1) / 2, (y0 + y1) / 2)};
    // The corner farthest from the middle bounds a block that is small; half a step more covers its bulging sides.
    float least = 1;
    for (const int x : {x0, (x0 + x1) / 2, x1})
        for (const int y : {y0, (y0 + y1) / 2, y1})
            least = std::min(least, dot(summary.axis, direction(x, y)));
    const float radius = std::min(1.1f * std::acos(std::clamp(least, -1.0f, 1.0f)) + 1e-3f, float(pi));
    summary.cos_radius = std::cos(radius);
    summary.sin_radius = std::sin(radius);
    return summary;
}

namespace {

glm::dvec3 eye_in_source(const Pose& eye, const Pose& source) {
    return glm::conjugate(source.orientation) * (eye.position_m - source.position_m);
}

}  // namespace

EyeProjection::EyeProjection(const PerspectiveCamera& camera, const Pose& eye, const Pose& source)
    : eye_(glm::vec3(eye_in_source(eye, source))), width_(camera.width), height_(camera.height) {
    const glm::dquat source_from_eye = glm::conjugate(source.orientation) * eye.orientation;
    const glm::dvec3 right = source_from_eye * glm::dvec3(1, 0, 0);
    const glm::dvec3 up = source_from_eye * glm::dvec3(0, 1, 0);
    const glm::dvec3 forward = source_from_eye * glm::dvec3(0, 0, -1);
    const double focal = camera.focal_px();
    x_ = glm::vec3(focal * right + (0.5 * camera.width - 0.5) * forward);
    y_ = glm::vec3(-focal * up + (0.5 * camera.height - 0.5) * forward);
    forward_ = glm::vec3(forward);
}

void EyeProjection::project(const LatticeBlock& block, ProjectedBlock& out) const {
    const glm::vec3 eye = eye_, across = x_, down = y_, forward = forward_;
    for (int i = 0; i < LatticeBlock::stride * LatticeBlock::stride; ++i) {
        const float k = block.k[i];
        const float ex = block.qx[i] - k * eye.x, ey = block.qy[i] - k * eye.y, ez = block.qz[i] - k * eye.z;
        const float z = forward.x * ex + forward.y * ey + forward.z * ez;
        const float scale = 1 / z;
        out.x[i] = (across.x * ex + across.y * ey + across.z * ez) * scale;
        out.y[i] = (down.x * ex + down.y * ey + down.z * ez) * scale;
        out.inverse_planar[i] = k * scale;
        out.forward[i] = z;
    }
}

SeenThrough::SeenThrough(const PerspectiveCamera& camera, const Pose& eye, const Pose& source, PixelBox box) {
    const glm::dquat source_from_eye = glm::conjugate(source.orientation) * eye.orientation;
    const glm::dvec3 position = eye_in_source(eye, source);
    const glm::dvec3 corners[4] = {camera.direction(box.x0, box.y0), camera.direction(box.x1, box.y0),
                                   camera.direction(box.x1, box.y1), camera.direction(box.x0, box.y1)};
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 n = glm::normalize(source_from_eye * glm::cross(corners[i], corners[(i + 1) % 4]));
        planes_[i] = {glm::vec3(n), float(glm::dot(n, position))};
    }
}

bool SeenThrough::may_show(const SourceLattice::Summary& block) const {
    return std::ranges::all_of(planes_, [&](const Plane& plane) {
        // The largest inwards . q over the block's cone, less the smallest k inwards . eye.
        const float cosine = dot(plane.inwards, block.axis);
        const float sine = std::sqrt(std::max(1 - cosine * cosine, 0.0f));
        const float largest = cosine >= block.cos_radius ? 1 : cosine * block.cos_radius + sine * block.sin_radius;
        const float least = std::min(block.nearest_inverse_m * plane.at_eye, block.farthest_inverse_m * plane.at_eye);
        return largest - least >= -1e-5f;
    });
}

}  // namespace equistream
