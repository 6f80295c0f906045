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
    const int left = tile.column * tile_side, top = tile.row * tile_side;
    const int columns = std::min(tile_side, picture_->origin.width() - left);
    const int rows = std::min(tile_side, picture_->origin.height() - top);
    std::array<std::array<float, tile_side>, tile_side> w{};
    std::array<std::array<bool, tile_side>, tile_side> gap{};
    for (int y = 0; y < rows; ++y) {
        const std::uint8_t* origin = picture_->origin.pixel(left, top + y);
        for (int x = 0; x < columns; ++x)
            gap[y][x] = origin[x] == std::uint8_t(PixelOrigin::gap);
        for (int x = 0; x < columns; ++x)
            w[y][x] = w_at(gap[y][x] ? depths_.gap_m : depths_.known_m, left + x, top + y);
    }
    for (int j = 0; j < tile_side / 2; ++j)
        for (int i = 0; i < tile_side / 2; ++i) {
            Cell& cell = tile.cells[4 * j + i];
            const int x = 2 * i, y = 2 * j;
            if (x + 1 < columns && y + 1 < rows && !(gap[y][x] | gap[y][x + 1] | gap[y + 1][x] | gap[y + 1][x + 1])) {
                const auto [low, high] = std::minmax({w[y][x], w[y][x + 1], w[y + 1][x], w[y + 1][x + 1]});
                if (high - low <= depths_.tolerance) {
                    const std::uint8_t* a = picture_->rgba.pixel(left + x, top + y);
                    const std::uint8_t* b = picture_->rgba.pixel(left + x, top + y + 1);
                    const auto mean = [&](int c) { return 0.25f * float(a[c] + a[c + 4] + b[c] + b[c + 4]); };
                    cell.layer[0] = {mean(0), mean(1), mean(2),
                                     0.25f * (w[y][x] + w[y][x + 1] + w[y + 1][x] + w[y + 1][x + 1])};
                    cell.state = {State::coloured, State::absent};
                    continue;
                }
            }
            Gathering children;
            for (int k = 0; k < 4; ++k) {
                const int u = x + k % 2, v = y + k / 2;
                if (u >= columns || v >= rows)
                    continue;
                const std::uint8_t* rgba = picture_->rgba.pixel(left + u, top + v);
                children.add({float(rgba[0]), float(rgba[1]), float(rgba[2]), w[v][u]},
                             gap[v][u] ? State::open : State::coloured);
            }
            cell = children.cell(depths_.tolerance);
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

/// The coarser level's layers around places between the same four cells: of columns `right` - 1 and `right`, of the row
/// that holds the places and the row beside it.
class PushPull::Sampler {
public:
    Sampler(const PushPull& pyramid, int coarser, int right, int y) : right_(right) {
        const int row = y >> 1, beside = row + ((y & 1) != 0 ? 1 : -1);
        add(pyramid.cell(coarser, right - 1, row), 0);
        add(pyramid.cell(coarser, right, row), 2);
        add(pyramid.cell(coarser, right - 1, beside), 4);
        add(pyramid.cell(coarser, right, beside), 6);
    }
    /// Of the cells between which place x lies.
    static int right_of(int x) { return (x + 1) >> 1; }
    int right() const { return right_; }

    /// False where nothing around has a colour.
    bool colour(float tolerance, int x, Layer& layer) const {
        // Along each axis the cell that holds the place lies nearer (3/4) than the one beside it (1/4).
        const float left = x >> 1 == right_ ? 0.25f : 0.75f;
        const std::array<float, 4> bilinear = {0.75f * left, 0.75f * (1 - left), 0.25f * left, 0.25f * (1 - left)};
        const float squared = tolerance * tolerance;
        std::array<float, 8> weight;
        for (int i = 0; i < 8; ++i) {
            const float difference = layers_[i].w - layer.w;
            weight[i] = coloured_[i] * bilinear[i / 2] * squared / (squared + difference * difference);
        }
        float sum = 0, r = 0, g = 0, b = 0;
        for (int i = 0; i < 8; ++i) {
            sum += weight[i];
            r += weight[i] * layers_[i].r;
            g += weight[i] * layers_[i].g;
            b += weight[i] * layers_[i].b;
        }
        if (!(sum > 0))
            return false;
        layer.r = r / sum;
        layer.g = g / sum;
        layer.b = b / sum;
        return true;
    }

private:
    void add(const Cell* cell, int i) {
        if (cell == nullptr)
            return;
        for (int half = 0; half < 2; ++half) {
            layers_[i + half] = cell->layer[half];
            coloured_[i + half] = cell->state[half] == State::coloured ? 1.0f : 0.0f;
        }
    }

    int right_;
    std::array<Layer, 8> layers_{};
    std::array<float, 8> coloured_{};
};

void PushPull::push_cell(int level, int x, int y, Cell& cell) const {
    if (cell.state[0] != State::open && cell.state[1] != State::open)
        return;
    const Sampler sampler(*this, level + 1, Sampler::right_of(x), y);
    for (int half = 0; half < 2; ++half)
        if (cell.state[half] == State::open && sampler.colour(depths_.tolerance, x, cell.layer[half]))
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
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tiles_.size(), 512), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            for (int k = 0; k < side * side; ++k)
                push_cell(level, tiles_[i].column * side + k % side, tiles_[i].row * side + k / side,
                          tiles_[i].cells[first_cell_of_level[level] + k]);
    });
}

std::int64_t PushPull::colour_gaps(const Gaps& gaps) {
    std::atomic<std::int64_t> total{0};
    const std::span<const GapSpan> spans = gaps.spans();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, spans.size(), 1024), [&](const auto& range) {
        std::int64_t coloured = 0;
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const int y = spans[i].y;
            Sampler sampler(*this, 1, Sampler::right_of(spans[i].begin), y);
            for (int x = spans[i].begin; x < spans[i].end; ++x) {
                if (Sampler::right_of(x) != sampler.right())
                    sampler = Sampler(*this, 1, Sampler::right_of(x), y);
                Layer layer{0, 0, 0, w_at(depths_.gap_m, x, y)};
                if (!sampler.colour(depths_.tolerance, x, layer))
                    continue;
                std::uint8_t* rgba = picture_->rgba.pixel(x, y);
                rgba[0] = std::uint8_t(layer.r + 0.5f);
                rgba[1] = std::uint8_t(layer.g + 0.5f);
                rgba[2] = std::uint8_t(layer.b + 0.5f);
                rgba[3] = 255;
                *picture_->origin.pixel(x, y) = std::uint8_t(PixelOrigin::push_pull);
                ++coloured;
            }
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
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tiles_.size(), 512), [&](const auto& range) {
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
