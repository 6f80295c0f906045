#include "push_pull.h"

#include "fill.h"
#include "gaps.h"

#include <equistream/bound.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace equistream {

namespace {

constexpr std::size_t tiles_at_once = 256, spans_at_once = 1024;

/// Calls work(first, last) for parts of so many tiles.
template <typename Work>
void over_tiles(std::size_t tiles, const Work& work) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tiles, tiles_at_once),
                      [&](const auto& range) { work(range.begin(), range.end()); });
}

}  // namespace

void PushPull::find_tiles(const Gaps& gaps, int width, int height) {
    constexpr int side = PullPyramid::tile_side;
    PullPyramid& p = pyramid_;
    p.tile_columns = (width + side - 1) / side;
    p.tile_rows = (height + side - 1) / side;
    constexpr std::int32_t none = -1, beside_gaps = 0, with_gaps = 1;
    p.tile_of.assign(std::size_t(p.tile_columns) * p.tile_rows, none);
    for (const GapSpan& span : gaps.spans()) {
        const int left = std::max(span.begin / side - 1, 0);
        const int right = std::min((span.end - 1) / side + 1, p.tile_columns - 1);
        const int row = span.y / side;
        for (int y = std::max(row - 1, 0); y <= std::min(row + 1, p.tile_rows - 1); ++y)
            std::fill(&p.tile_of[std::size_t(y) * p.tile_columns + left],
                      &p.tile_of[std::size_t(y) * p.tile_columns + right] + 1, beside_gaps);
    }
    for (const GapSpan& span : gaps.spans())
        std::fill(&p.tile_of[std::size_t(span.y / side) * p.tile_columns + span.begin / side],
                  &p.tile_of[std::size_t(span.y / side) * p.tile_columns + (span.end - 1) / side] + 1, with_gaps);
    p.tiles_with_gaps.clear();
    std::size_t count = 0;
    for (int row = 0; row < p.tile_rows; ++row)
        for (int column = 0; column < p.tile_columns; ++column) {
            std::int32_t& tile = p.tile_of[std::size_t(row) * p.tile_columns + column];
            if (tile == none)
                continue;
            if (tile == with_gaps)
                p.tiles_with_gaps.push_back(std::int32_t(count));
            tile = std::int32_t(count);
            if (count == p.tiles.size())
                p.tiles.emplace_back();
            p.tiles[count].column = column;
            p.tiles[count].row = row;
            ++count;
        }
    p.tiles.resize(count);
    p.tile_layers.resize(count);
}

void PushPull::size_upper_levels() {
    int columns = pyramid_.tile_columns, rows = pyramid_.tile_rows;
    std::size_t count = 0;
    for (; columns > 1 || rows > 1; ++count) {
        columns = (columns + 1) / 2;
        rows = (rows + 1) / 2;
        if (count == pyramid_.upper_levels.size())
            pyramid_.upper_levels.emplace_back();
        PullPyramid::Level& level = pyramid_.upper_levels[count];
        level.columns = columns;
        level.rows = rows;
        level.cells.resize(std::size_t(columns) * rows);
    }
    pyramid_.upper_levels.resize(count);
}

std::int64_t PushPull::run(const SurfaceDepths& depths, const Gaps& gaps, EyePicture& picture) {
    if (gaps.empty())
        return 0;
    pyramid_.depths = depths;
    pyramid_.picture = &picture;
    find_tiles(gaps, picture.origin.width(), picture.origin.height());
    size_upper_levels();
    over_tiles(pyramid_.tiles.size(), [&](std::size_t first, std::size_t last) { pull_tiles(pyramid_, first, last); });
    const int top = PullPyramid::tile_levels + int(pyramid_.upper_levels.size());
    for (int level = PullPyramid::tile_levels + 1; level <= top; ++level)
        pull_upper_level(pyramid_, level);
    for (int level = top - 1; level > PullPyramid::tile_levels; --level)
        push_upper_level(pyramid_, level);
    for (int level = std::min(top - 1, PullPyramid::tile_levels); level >= 1; --level)
        over_tiles(pyramid_.tiles_with_gaps.size(),
                   [&](std::size_t first, std::size_t last) { push_tiles(pyramid_, level, first, last); });
    std::atomic<std::int64_t> coloured{0};
    const std::span<const GapSpan> spans = gaps.spans();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, spans.size(), spans_at_once), [&](const auto& range) {
        coloured += colour_spans(pyramid_, spans.subspan(range.begin(), range.size()));
    });
    return coloured;
}

namespace {

/// Coarser levels of the picture itself.
class PushPullPass : public FillPass {
public:
    PushPullPass() : FillPass("pushpull", false) {}
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    struct Workspace {
        PushPull pyramid;
        FloatImage background_m;
    };

    mutable ObjectPool<Workspace> pool_;
};

std::int64_t PushPullPass::fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const {
    if (gaps.empty())
        return 0;
    std::unique_ptr<Workspace> work = pool_.acquire();
    // The main source from the eye, in the eye's axes; 0 where nobody has said where that is.
    glm::dvec3 source(0);
    SurfaceDepths depths;
    if (const SourceView* main = inputs_.main) {
        source = glm::conjugate(eye.pose.orientation) * (main->pose.position_m - eye.pose.position_m);
        depths.box_radius_m = float(std::max(main->box_radius_m, glm::length(source)));
    }
    depths.tolerance = float(std::sin(error_budget_rad(eye.camera.focal_px(), inputs_.error_budget_px)));
    if (eye.depth_m.data != nullptr) {
        depths.known_m = depths.gap_m = eye.depth_m;
    } else if (!picture.depth_m.empty()) {
        find_background(eye, picture, gaps, source, work->background_m);
        depths.known_m = picture.depth_m.view();
        depths.gap_m = work->background_m.view();
    }
    const std::int64_t filled = work->pyramid.run(depths, gaps, picture);
    if (eye.depth_m.data == nullptr && !picture.depth_m.empty())
        for (const GapSpan& span : gaps.spans())
            std::copy_n(work->background_m.pixel(span.begin, span.y), span.end - span.begin,
                        picture.depth_m.pixel(span.begin, span.y));
    pool_.release(std::move(work));
    gaps.narrow(picture.origin.view());
    return filled;
}

}  // namespace

std::unique_ptr<FillPass> make_push_pull_pass() {
    return std::make_unique<PushPullPass>();
}

}  // namespace equistream
