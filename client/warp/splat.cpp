#include "source_depth_engine.h"
#include "splat_order.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace equistream {

SplatOrder::SplatOrder(const Camera& source, const glm::dvec3& eye) {
    const int width = width_of(source);
    if (const auto* sphere = std::get_if<EquirectCamera>(&source)) {
        const Vector3<double> epipole{eye.x, eye.y, eye.z};
        const double longitude_of_epipole = longitude_of(epipole);
        const double tangent = std::tan(latitude_of(epipole));
        const double rows_per_radian = sphere->height / sphere->range.latitude_span();
        for (int x = 0; x < width; ++x) {
            const double longitude = sphere->range.longitude_min + (x + 0.5) * sphere->range.longitude_span() / width;
            const double apart = std::abs(std::remainder(longitude - longitude_of_epipole, 2 * pi));
            earliness_.push_back(apart);
            turning_row_.push_back((sphere->range.latitude_max - std::atan(tangent / std::cos(apart))) *
                                   rows_per_radian);
            towards_.push_back(apart < pi / 2);
        }
        return;
    }
    // An eye beside the source has its epipole at infinity; so far away only the side counts.
    const auto& perspective = std::get<PerspectiveCamera>(source);
    const bool in_front = eye.z < 0;
    const double forward = std::max(std::abs(eye.z), 1e-9 * glm::length(eye)) * (in_front ? 1 : -1);
    const double focal = perspective.focal_px();
    const double column = 0.5 * perspective.width + focal * eye.x / forward;
    const double row = 0.5 * perspective.height - focal * eye.y / forward;
    for (int x = 0; x < width; ++x) {
        const double apart = std::abs(x + 0.5 - column);
        earliness_.push_back(in_front ? apart : -apart);
        turning_row_.push_back(row);
        towards_.push_back(in_front);
    }
}

namespace {

/// A source pixel as a parallelogram of the eye's, with the plane of its inverse depths: of the offset (dx, dy) from
/// its middle, |across| <= 1 and |down| <= 1 inside.
struct Footprint {
    float x, y, inverse_planar;
    float slope_x, slope_y;    ///< of inverse_planar, a pixel of the eye
    float across_x, across_y;  ///< across = across_x dx + across_y dy
    float down_x, down_y;
    float half_width, half_height;  ///< of the box around it
    int row;
};

struct Step {
    float x = 0, y = 0, inverse_planar = 0;
};

Step operator-(const EyePoint& a, const EyePoint& b) {
    return {a.x - b.x, a.y - b.y, a.inverse_planar - b.inverse_planar};
}
float length(Step s) {
    return std::sqrt(s.x * s.x + s.y * s.y);
}

/// From one side's middle to the other's, and how far each lies from the pixel's centre as a share of that.
struct Axis {
    Step step;
    float half = 0.5f + footprint_overlap;
};

/// `before` and `after` lead from one neighbour to the pixel and on to the other.
Axis between(bool joined_before, Step before, bool joined_after, Step after) {
    if (!joined_before)
        return {after};
    if (!joined_after)
        return {before};
    const Step mean{0.5f * (before.x + after.x), 0.5f * (before.y + after.y),
                    0.5f * (before.inverse_planar + after.inverse_planar)};
    // Reaches halfway to the farther neighbour.
    const float longest = std::max(length(before), length(after));
    const float mean_length = length(mean);
    return {mean, mean_length > 0 ? 0.5f * longest / mean_length + footprint_overlap : 0};
}

/// By row, how much wider a pixel is at its wider edge than in its middle: much next to a sphere's poles.
std::vector<float> widenings(const SourceLattice& lattice) {
    const auto width = [&](int y) {
        const glm::vec3 chord = lattice.direction(1, y) - lattice.direction(0, y);
        return std::sqrt(dot(chord, chord));
    };
    std::vector<float> rows;
    for (int y = 0; y < lattice.height(); ++y)
        rows.push_back(0.5f + 0.5f * std::max(width(y - 1), width(y + 1)) / width(y));
    return rows;
}

/// What one thread works with.
struct SplatScratch {
    LatticeBlock block;
    JoinedPoints joined;
    ProjectedBlock projected;
    std::vector<std::vector<Footprint>> columns{std::size_t(LatticeBlock::side)};
};

/// One vertical band of the eye, drawn by one thread.
class BandOfSplats {
public:
    BandOfSplats(const FindingTask& task, const EyeProjection& projection, const SplatOrder& order,
                 const std::vector<float>& widening, PixelBox box)
        : task_(task), projection_(projection), order_(order), widening_(widening), box_(box),
          seen_(task.eye.camera, task.eye.pose, task.source.pose, box) {}

    void draw(SplatScratch& scratch, FloatImage& target) {
        for (const int block_x : block_columns_in_order()) {
            for (std::vector<Footprint>& column : scratch.columns)
                column.clear();
            int first_column = 0;
            for (int block_y = 0; block_y < task_.lattice.block_rows(); ++block_y) {
                if (!seen_.may_show(task_.lattice.summary(block_x, block_y)))
                    continue;
                add_block(block_x, block_y, scratch);
                first_column = scratch.block.x0;
            }
            draw_columns(first_column, scratch.columns, target);
        }
    }

private:
    std::vector<int> block_columns_in_order() const {
        struct Block {
            double latest, earliest;
            int column;
        };
        std::vector<Block> order;
        for (int block_x = 0; block_x < task_.lattice.block_columns(); ++block_x) {
            const int first = std::max(task_.lattice.first_column() + block_x * LatticeBlock::side, 0);
            const int last = std::min(first + LatticeBlock::side, task_.lattice.width()) - 1;
            Block block{order_.earliness(first), order_.earliness(first), block_x};
            for (int x = first + 1; x <= last; ++x) {
                block.latest = std::min(block.latest, order_.earliness(x));
                block.earliest = std::max(block.earliest, order_.earliness(x));
            }
            order.push_back(block);
        }
        // The latest of its columns counts: the block that an epipole is in goes last, however far it reaches. The
        // block that the order begins in goes first: by its latest column alone, a narrow neighbour could come before
        // it.
        const auto begin = std::ranges::max_element(order, {}, &Block::earliest);
        if (begin != std::ranges::min_element(order, {}, &Block::latest))
            begin->latest = std::numeric_limits<double>::infinity();
        std::ranges::stable_sort(order, std::ranges::greater(), &Block::latest);
        std::vector<int> columns;
        for (const Block& block : order)
            columns.push_back(block.column);
        return columns;
    }

    void add_block(int block_x, int block_y, SplatScratch& scratch) const {
        LatticeBlock& block = scratch.block;
        task_.lattice.load(block_x, block_y, block);
        find_joined(block, task_.same_surface, scratch.joined);
        forget_edges(block, scratch.joined);
        projection_.project(block, scratch.projected);
        for (int y = 0; y < block.rows; ++y)
            if (block.y0 + y >= 0)
                for (int x = block.x0 < 0 ? 1 : 0; x < block.columns; ++x)
                    add_footprint(scratch, x, y, scratch.columns[std::size_t(x)]);
    }

    /// The points on a picture's edge are no samples, and half as far away.
    void forget_edges(const LatticeBlock& block, JoinedPoints& joined) const {
        const auto clear = [&](std::array<std::uint8_t, LatticeBlock::stride * LatticeBlock::stride>& flags, int from,
                               int step) {
            for (int i = 0; i < LatticeBlock::stride; ++i)
                flags[from + i * step] = 0;
        };
        constexpr int before = LatticeBlock::before, stride = LatticeBlock::stride;
        const int inner_x = std::max(block.x0, 0), inner_y = std::max(block.y0, 0);
        if (!task_.lattice.is_sample(block.x0, inner_y))
            clear(joined.right, LatticeBlock::at(0, -before), stride);
        if (!task_.lattice.is_sample(block.x0 + block.columns, inner_y))
            clear(joined.right, LatticeBlock::at(block.columns - 1, -before), stride);
        if (!task_.lattice.is_sample(inner_x, block.y0))
            clear(joined.down, LatticeBlock::at(-before, 0), 1);
        if (!task_.lattice.is_sample(inner_x, block.y0 + block.rows))
            clear(joined.down, LatticeBlock::at(-before, block.rows - 1), 1);
    }

    /// Farther from the box than a footprint reaches.
    bool far_out(const EyePoint& middle) const {
        return middle.x < float(box_.x0) - max_half_side || middle.x > float(box_.x1) + max_half_side ||
               middle.y < float(box_.y0) - max_half_side || middle.y > float(box_.y1) + max_half_side;
    }

    void add_footprint(const SplatScratch& of, int x, int y, std::vector<Footprint>& column) const {
        const LatticeBlock& block = of.block;
        const int i = LatticeBlock::at(x, y);
        const EyePoint middle = of.projected.at(i);
        if (!middle.before || !(block.k[i] >= 0) || far_out(middle))
            return;
        const auto axis = [&](int step, const std::uint8_t* joined, glm::vec3 beside) -> Axis {
            const EyePoint before = of.projected.at(i - step), after = of.projected.at(i + step);
            const bool joined_before = joined[i - step] && before.before, joined_after = joined[i] && after.before;
            if (joined_before || joined_after)
                return between(joined_before, middle - before, joined_after, after - middle);
            // On its own: the pixel's solid angle at its own distance.
            return {projection_.project({beside, block.k[i]}) - middle};
        };
        Axis across = axis(1, of.joined.right.data(), block.point(x + 1, y).q);
        across.half *= widening_[std::size_t(block.y0 + y)];
        const Axis down = axis(LatticeBlock::stride, of.joined.down.data(), block.point(x, y + 1).q);
        const float area = across.step.x * down.step.y - across.step.y * down.step.x;
        if (!(area > 0))
            return;  // the eye sees its back
        const float half_width = across.half * std::abs(across.step.x) + down.half * std::abs(down.step.x);
        const float half_height = across.half * std::abs(across.step.y) + down.half * std::abs(down.step.y);
        const bool outside = middle.x + half_width < float(box_.x0) || middle.x - half_width > float(box_.x1 - 1) ||
                             middle.y + half_height < float(box_.y0) || middle.y - half_height > float(box_.y1 - 1);
        if (outside || half_width > max_half_side || half_height > max_half_side)
            return;
        const float u_x = down.step.y / area, u_y = -down.step.x / area;
        const float v_x = -across.step.y / area, v_y = across.step.x / area;
        column.push_back({middle.x, middle.y, middle.inverse_planar,
                          across.step.inverse_planar * u_x + down.step.inverse_planar * v_x,
                          across.step.inverse_planar * u_y + down.step.inverse_planar * v_y, u_x / across.half,
                          u_y / across.half, v_x / down.half, v_y / down.half, half_width, half_height, block.y0 + y});
    }

    void draw_columns(int first_column, const std::vector<std::vector<Footprint>>& columns, FloatImage& target) const {
        std::array<int, LatticeBlock::side> order{};
        int count = 0;
        for (int x = 0; x < LatticeBlock::side; ++x)
            if (!columns[x].empty())
                order[count++] = x;
        std::sort(order.begin(), order.begin() + count, [&](int a, int b) {
            return order_.earliness(first_column + a) > order_.earliness(first_column + b);
        });
        for (int i = 0; i < count; ++i) {
            const std::vector<Footprint>& column = columns[order[i]];
            const double turning_row = order_.turning_row(first_column + order[i]);
            const auto turn = std::ranges::partition_point(
                column, [&](const Footprint& footprint) { return footprint.row + 0.5 < turning_row; });
            if (order_.towards_turning_row(first_column + order[i])) {
                std::for_each(column.begin(), turn, [&](const Footprint& f) { draw(f, target); });
                std::for_each(column.rbegin(), std::make_reverse_iterator(turn),
                              [&](const Footprint& f) { draw(f, target); });
            } else {
                std::for_each(std::make_reverse_iterator(turn), column.rend(),
                              [&](const Footprint& f) { draw(f, target); });
                std::for_each(turn, column.end(), [&](const Footprint& f) { draw(f, target); });
            }
        }
    }

    void draw(const Footprint& f, FloatImage& target) const {
        const int x0 = std::max(int(std::ceil(f.x - f.half_width)), box_.x0);
        const int x1 = std::min(int(std::floor(f.x + f.half_width)), box_.x1 - 1);
        const int y0 = std::max(int(std::ceil(f.y - f.half_height)), box_.y0);
        const int y1 = std::min(int(std::floor(f.y + f.half_height)), box_.y1 - 1);
        for (int y = y0; y <= y1; ++y) {
            float* row = target.pixel(0, y);
            const float dy = float(y) - f.y;
            for (int x = x0; x <= x1; ++x) {
                const float dx = float(x) - f.x;
                const float across = f.across_x * dx + f.across_y * dy;
                const float down = f.down_x * dx + f.down_y * dy;
                if (std::abs(across) <= 1 && std::abs(down) <= 1)
                    row[x] = std::max(f.inverse_planar + f.slope_x * dx + f.slope_y * dy, 0.0f);
            }
        }
    }

    const FindingTask& task_;
    const EyeProjection& projection_;
    const SplatOrder& order_;
    const std::vector<float>& widening_;
    PixelBox box_;
    SeenThrough seen_;
};

}  // namespace

void find_by_splats(const FindingTask& task, FloatImage& inverse_planar) {
    const EyeProjection projection(task.eye.camera, task.eye.pose, task.source.pose);
    const SplatOrder order(task.source.camera, glm::conjugate(task.source.pose.orientation) *
                                                   (task.eye.pose.position_m - task.source.pose.position_m));
    const std::vector<float> widening = widenings(task.lattice);
    tbb::enumerable_thread_specific<SplatScratch> scratches;
    const int width = task.eye.camera.width, height = task.eye.camera.height;
    // A sphere's columns are all but the eye's: tall bands share few blocks.
    constexpr int band_px = 160;
    tbb::parallel_for(0, (width + band_px - 1) / band_px, [&](int band) {
        const PixelBox box{band * band_px, 0, std::min((band + 1) * band_px, width), height};
        BandOfSplats(task, projection, order, widening, box).draw(scratches.local(), inverse_planar);
    });
}

}  // namespace equistream
