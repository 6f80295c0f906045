#include "wide_gaps.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace equistream {

namespace {

/// Which spans hang together, and which such components hold a square.
class Components {
public:
    explicit Components(std::span<const GapSpan> spans) : parents_(spans.size()), wide_(spans.size(), false) {
        std::iota(parents_.begin(), parents_.end(), std::size_t(0));
        // `above` runs along the row before, whose spans lie in the same order.
        for (std::size_t i = 0, above = 0; i < spans.size(); ++i) {
            while (spans[above].y < spans[i].y - 1)
                ++above;
            while (spans[above].y < spans[i].y && spans[above].end < spans[i].begin)
                ++above;
            for (std::size_t k = above; spans[k].y < spans[i].y && spans[k].begin <= spans[i].end; ++k)
                join(k, i);
        }
    }

    void mark_wide(std::size_t span) { wide_[root(span)] = true; }
    bool is_wide(std::size_t span) { return wide_[root(span)]; }

private:
    std::size_t root(std::size_t span) {
        while (parents_[span] != span)
            span = parents_[span] = parents_[parents_[span]];
        return span;
    }
    void join(std::size_t a, std::size_t b) { parents_[root(b)] = root(a); }

    std::vector<std::size_t> parents_;
    std::vector<bool> wide_;
};

/// How many rows a column of gaps has had so far, down to the row last looked at.
struct Column {
    int y = -2, height = 0;
};

bool ends_a_square(const GapSpan& span, int side, std::vector<Column>& columns) {
    bool found = false;
    for (int x = span.begin, wide = 0; x < span.end; ++x) {
        Column& column = columns[std::size_t(x)];
        column.height = column.y == span.y - 1 ? column.height + 1 : 1;
        column.y = span.y;
        wide = column.height >= side ? wide + 1 : 0;
        found |= wide >= side;
    }
    return found;
}

}  // namespace

Gaps wide_gaps(const Gaps& gaps, int width, int side) {
    const std::span<const GapSpan> spans = gaps.spans();
    Components components(spans);
    std::vector<Column> columns(static_cast<std::size_t>(width));
    for (std::size_t i = 0; i < spans.size(); ++i)
        if (ends_a_square(spans[i], side, columns))
            components.mark_wide(i);
    std::vector<GapSpan> wide;
    for (std::size_t i = 0; i < spans.size(); ++i)
        if (components.is_wide(i))
            wide.push_back(spans[i]);
    return Gaps(std::move(wide));
}

int wide_gap_side(const PerspectiveCamera& eye, const Camera& source) {
    const double angle_rad = std::visit([](const auto& camera) { return camera.pixel_angle_rad(); }, source);
    return int(std::clamp(std::round(angle_rad / eye.pixel_angle_rad() / 2), 1.0, double(eye.width)));
}

}  // namespace equistream
