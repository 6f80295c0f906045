#include "push_pull.h"

#include <equistream/depth_agreement.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace equistream {

/// The children's layers of one cell.
class PushPull::Gathering {
public:
    void add(const Layer& layer, State state) {
        if (state == State::absent)
            return;
        layers_[count_] = layer;
        coloured_[count_] = state == State::coloured ? 1.0f : 0.0f;
        low_ = std::min(low_, layer.w);
        high_ = std::max(high_, layer.w);
        ++count_;
    }

    Cell cell(float tolerance) const {
        Cell cell;
        if (count_ == 0)
            return cell;
        const float split = high_ - low_ > tolerance ? 0.5f * (low_ + high_) : high_;
        std::array<Layer, 2> sum{};
        std::array<float, 2> present{}, coloured{};
        for (int i = 0; i < count_; ++i) {
            const Layer& from = layers_[i];
            const int half = from.w <= split ? 0 : 1;
            Layer& to = sum[half];
            present[half] += 1;
            coloured[half] += coloured_[i];
            to.w += from.w;
            to.r += coloured_[i] * from.r;
            to.g += coloured_[i] * from.g;
            to.b += coloured_[i] * from.b;
        }
        for (int half = 0; half < 2; ++half) {
            if (present[half] == 0)
                continue;
            const float scale = coloured[half] > 0 ? 1 / coloured[half] : 0;
            cell.layer[half] = {sum[half].r * scale, sum[half].g * scale, sum[half].b * scale,
                                sum[half].w / present[half]};
            cell.state[half] = coloured[half] > 0 ? State::coloured : State::open;
        }
        return cell;
    }

private:
    std::array<Layer, 8> layers_;
    std::array<float, 8> coloured_;
    int count_ = 0;
    float low_ = std::numeric_limits<float>::infinity(), high_ = -std::numeric_limits<float>::infinity();
};

namespace {

constexpr int first_cell_of_level[] = {0, 0, 16, 20};  ///< in a tile, by level

}  // namespace

float PushPull::w_at(ImageView<const float> depth_m, int x, int y) const {
    if (depth_m.data == nullptr)
        return 0;
    const float depth = depth_m.pixel(x, y)[0];
    if (!(depth > 0))
        return 0;
    return depths_.box_radius_m / DepthAgreement{depths_.box_radius_m, depths_.tolerance}.reach(depth);
}

const PushPull::Cell* PushPull::cell(int level, int x, int y) const {
    if (x < 0 || y < 0)
        return nullptr;
    if (level > tile_levels) {
        const Level& upper = upper_[level - tile_levels - 1];
        return x < upper.columns && y < upper.rows ? &upper.cells[std::size_t(y) * upper.columns + x] : nullptr;
    }
    const int shift = tile_levels - level;
    const int column = x >> shift, row = y >> shift;
    if (column >= tile_columns_ || row >= tile_rows_)
        return nullptr;
    const std::int32_t tile = tile_of_[std::size_t(row) * tile_columns_ + column];
    if (tile < 0)
        return nullptr;
    const int mask = (1 << shift) - 1;
    return &tiles_[tile].cells[first_cell_of_level[level] + ((y & mask) << shift) + (x & mask)];
}

void PushPull::find_tiles(const Gaps& gaps, int width, int height) {
    tile_columns_ = (width + tile_side - 1) / tile_side;
    tile_rows_ = (height + tile_side - 1) / tile_side;
    tile_of_.assign(std::size_t(tile_columns_) * tile_rows_, -1);
    for (const GapSpan& span : gaps.spans()) {
        const int left = std::max(span.begin / tile_side - 1, 0);
        const int right = std::min((span.end - 1) / tile_side + 1, tile_columns_ - 1);
        const int row = span.y / tile_side;
        for (int y = std::max(row - 1, 0); y <= std::min(row + 1, tile_rows_ - 1); ++y)
            std::fill(&tile_of_[std::size_t(y) * tile_columns_ + left],
                      &tile_of_[std::size_t(y) * tile_columns_ + right] + 1, 0);
    }
    std::size_t count = 0;
    for (int row = 0; row < tile_rows_; ++row)
        for (int column = 0; column < tile_columns_; ++column) {
            std::int32_t& tile = tile_of_[std::size_t(row) * tile_columns_ + column];
            if (tile < 0)
                continue;
            tile = std::int32_t(count);
            if (count == tiles_.size())
                tiles_.emplace_back();
            tiles_[count].column = column;
            tiles_[count].row = row;
            ++count;
        }
    tiles_.resize(count);
}

void PushPull::pull_pixels(Tile& tile) const {
    const int width = picture_->origin.width(), height = picture_->origin.height();
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) {
            Gathering children;
            for (int k = 0; k < 4; ++k) {
                const int x = tile.column * tile_side + 2 * i + (k & 1), y = tile.row * tile_side + 2 * j + (k >> 1);
                if (x >= width || y >= height)
                    continue;
                const bool gap = *picture_->origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap);
                const std::uint8_t* rgba = picture_->rgba.pixel(x, y);
                children.add(
                    {float(rgba[0]), float(rgba[1]), float(rgba[2]), w_at(gap ? depths_.gap_m : depths_.known_m, x, y)},
                    gap ? State::open : State::coloured);
            }
            tile.cells[4 * j + i] = children.cell(depths_.tolerance);
        }
}

void PushPull::pull_tile(Tile& tile) const {
    pull_pixels(tile);
    for (int level = 2; level <= tile_levels; ++level) {
        const int side = 1 << (tile_levels - level);
        const Cell* finer = &tile.cells[first_cell_of_level[level - 1]];
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                Gathering children;
                for (int k = 0; k < 4; ++k) {
                    const Cell& child = finer[(2 * y + (k >> 1)) * 2 * side + 2 * x + (k & 1)];
                    children.add(child.layer[0], child.state[0]);
                    children.add(child.layer[1], child.state[1]);
                }
                tile.cells[first_cell_of_level[level] + y * side + x] = children.cell(depths_.tolerance);
            }
    }
}

void PushPull::pull_upper_levels() {
    int columns = tile_columns_, rows = tile_rows_, level = tile_levels;
    for (std::size_t i = 0; columns > 1 || rows > 1; ++i) {
        columns = (columns + 1) / 2;
        rows = (rows + 1) / 2;
        if (i == upper_.size())
            upper_.emplace_back();
        upper_[i].columns = columns;
        upper_[i].rows = rows;
        upper_[i].cells.resize(std::size_t(columns) * rows);
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x) {
                Gathering children;
                for (int k = 0; k < 4; ++k)
                    if (const Cell* child = cell(level, 2 * x + (k & 1), 2 * y + (k >> 1)); child != nullptr) {
                        children.add(child->layer[0], child->state[0]);
                        children.add(child->layer[1], child->state[1]);
                    }
                upper_[i].cells[std::size_t(y) * columns + x] = children.cell(depths_.tolerance);
            }
        ++level;
    }
    upper_.resize(std::size_t(level - tile_levels));
}

/// The coarser level's layers around one place: their weights for the place's w, and their mean.
class PushPull::Sampler {
public:
    Sampler(const PushPull& pyramid, int coarser, int x, int y) {
        // Along each axis the cell that holds the place lies nearer (3/4) than the one beside it (1/4).
        const int near_x = x >> 1, near_y = y >> 1;
        const int beside_x = near_x + ((x & 1) != 0 ? 1 : -1), beside_y = near_y + ((y & 1) != 0 ? 1 : -1);
        add(pyramid.cell(coarser, near_x, near_y), 9.0f / 16);
        add(pyramid.cell(coarser, beside_x, near_y), 3.0f / 16);
        add(pyramid.cell(coarser, near_x, beside_y), 3.0f / 16);
        add(pyramid.cell(coarser, beside_x, beside_y), 1.0f / 16);
    }

    /// False where nothing around has a colour.
    bool colour(float tolerance, Layer& layer) const {
        float sum = 0, r = 0, g = 0, b = 0;
        const float squared = tolerance * tolerance;
        for (int i = 0; i < count_; ++i) {
            const float difference = layers_[i]->w - layer.w;
            const float weight = weights_[i] * squared / (squared + difference * difference);
            sum += weight;
            r += weight * layers_[i]->r;
            g += weight * layers_[i]->g;
            b += weight * layers_[i]->b;
        }
        if (!(sum > 0))
            return false;
        layer.r = r / sum;
        layer.g = g / sum;
        layer.b = b / sum;
        return true;
    }

private:
    void add(const Cell* cell, float weight) {
        if (cell == nullptr)
            return;
        for (int half = 0; half < 2; ++half)
            if (cell->state[half] == State::coloured) {
                layers_[count_] = &cell->layer[half];
                weights_[count_++] = weight;
            }
    }

    std::array<const Layer*, 8> layers_;
    std::array<float, 8> weights_;
    int count_ = 0;
};

void PushPull::push_cell(int level, int x, int y, Cell& cell) const {
    if (cell.state[0] != State::open && cell.state[1] != State::open)
        return;
    const Sampler sampler(*this, level + 1, x, y);
    for (int half = 0; half < 2; ++half)
        if (cell.state[half] == State::open && sampler.colour(depths_.tolerance, cell.layer[half]))
            cell.state[half] = State::coloured;
}

void PushPull::push_upper_levels() {
    for (int i = int(upper_.size()) - 2; i >= 0; --i) {
        Level& level = upper_[i];
        for (int y = 0; y < level.rows; ++y)
            for (int x = 0; x < level.columns; ++x)
                push_cell(i + tile_levels + 1, x, y, level.cells[std::size_t(y) * level.columns + x]);
    }
}

void PushPull::push_tiles(int level) {
    const int side = 1 << (tile_levels - level);
    if (level == tile_levels && upper_.empty())
        return;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tiles_.size(), 64), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            for (int k = 0; k < side * side; ++k)
                push_cell(level, tiles_[i].column * side + k % side, tiles_[i].row * side + k / side,
                          tiles_[i].cells[first_cell_of_level[level] + k]);
    });
}

std::int64_t PushPull::colour_gaps(const Gaps& gaps) {
    std::atomic<std::int64_t> total{0};
    const std::span<const GapSpan> spans = gaps.spans();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, spans.size(), 64), [&](const auto& range) {
        std::int64_t coloured = 0;
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            for (int x = spans[i].begin, y = spans[i].y; x < spans[i].end; ++x) {
                Layer layer{0, 0, 0, w_at(depths_.gap_m, x, y)};
                if (!Sampler(*this, 1, x, y).colour(depths_.tolerance, layer))
                    continue;
                std::uint8_t* rgba = picture_->rgba.pixel(x, y);
                rgba[0] = std::uint8_t(layer.r + 0.5f);
                rgba[1] = std::uint8_t(layer.g + 0.5f);
                rgba[2] = std::uint8_t(layer.b + 0.5f);
                rgba[3] = 255;
                *picture_->origin.pixel(x, y) = std::uint8_t(PixelOrigin::push_pull);
                ++coloured;
            }
        total += coloured;
    });
    return total;
}

std::int64_t PushPull::run(const SurfaceDepths& depths, const Gaps& gaps, EyePicture& picture) {
    if (gaps.empty())
        return 0;
    depths_ = depths;
    picture_ = &picture;
    find_tiles(gaps, picture.origin.width(), picture.origin.height());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tiles_.size(), 32), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            pull_tile(tiles_[i]);
    });
    pull_upper_levels();
    push_upper_levels();
    for (int level = tile_levels; level >= 1; --level)
        push_tiles(level);
    return colour_gaps(gaps);
}

}  // namespace equistream
