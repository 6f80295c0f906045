#include "plain_engines.h"

#include <equistream/visible_loss.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace equistream::plain {

namespace {

constexpr std::uint8_t on_silhouette = 3;

/// Whether inverse depth steps between b and c more than the slopes beside the step explain.
inline std::uint8_t steps(float a, float b, float c, float d, float least) {
    const float step = std::abs(c - b);
    const float slope = std::max(std::abs(b - a), std::abs(d - c));
    return step > least && step > 2 * slope ? on_silhouette : 0;
}

/// Steps to the right of each pixel, and what is beside them.
void mark_along_row(const float* q, int width, float least, std::uint8_t* scratch, std::uint8_t* out) {
    for (int x = 0; x + 1 < width; ++x)
        scratch[x] = steps(q[std::max(0, x - 1)], q[x], q[x + 1], q[std::min(width - 1, x + 2)], least);
    for (int x = 0; x < width; ++x)
        out[x] = std::max({out[x], scratch[std::max(0, x - 1)], scratch[x]});
}

/// A step between rows `above` and `above` + 1.
void mark_between_rows(const FloatImage& q, int above, float least, std::uint8_t* out) {
    if (above < 0 || above + 1 >= q.height())
        return;
    const float *a = q.pixel(0, std::max(0, above - 1)), *b = q.pixel(0, above), *c = q.pixel(0, above + 1),
                *d = q.pixel(0, std::min(q.height() - 1, above + 2));
    for (int x = 0; x < q.width(); ++x)
        out[x] = std::max(out[x], steps(a[x], b[x], c[x], d[x], least));
}

void mark_origins(const ByteImage& origin, int y, std::uint8_t* out) {
    const int width = origin.width();
    const std::uint8_t* here = origin.pixel(0, y);
    const std::uint8_t* above = origin.pixel(0, std::max(0, y - 1));
    const std::uint8_t* below = origin.pixel(0, std::min(origin.height() - 1, y + 1));
    for (int x = 0; x < width; ++x)
        out[x] = here[x] != above[x] || here[x] != below[x] ? on_silhouette : out[x];
    for (int x = 1; x < width; ++x)
        out[x] = here[x] != here[x - 1] ? on_silhouette : out[x];
    for (int x = 0; x + 1 < width; ++x)
        out[x] = here[x] != here[x + 1] ? on_silhouette : out[x];
}

/// Every pixel at least one less than its eight neighbours.
void spread(ByteImage& marks, ByteImage& scratch) {
    const int width = marks.width(), height = marks.height();
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const tbb::blocked_range<int>& rows) {
        for (int y = rows.begin(); y < rows.end(); ++y) {
            const std::uint8_t* m = marks.pixel(0, y);
            std::uint8_t* s = scratch.pixel(0, y);
            s[0] = std::max(m[0], m[std::min(1, width - 1)]);
            s[width - 1] = std::max(m[width - 1], m[std::max(0, width - 2)]);
            for (int x = 1; x + 1 < width; ++x)
                s[x] = std::max({m[x - 1], m[x], m[x + 1]});
        }
    });
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const tbb::blocked_range<int>& rows) {
        for (int y = rows.begin(); y < rows.end(); ++y) {
            const std::uint8_t* a = scratch.pixel(0, std::max(0, y - 1));
            const std::uint8_t* b = scratch.pixel(0, y);
            const std::uint8_t* c = scratch.pixel(0, std::min(height - 1, y + 1));
            std::uint8_t* m = marks.pixel(0, y);
            for (int x = 0; x < width; ++x) {
                const std::uint8_t largest = std::max({a[x], b[x], c[x]});
                m[x] = std::max<std::uint8_t>(m[x], largest > 0 ? std::uint8_t(largest - 1) : std::uint8_t(0));
            }
        }
    });
}

inline std::uint8_t one_more(std::uint8_t steps) {
    return steps < 255 ? std::uint8_t(steps + 1) : std::uint8_t(255);
}

}  // namespace

ByteImage silhouette_closeness(const FloatImage& inverse_planar, const ByteImage& origin, float step_inverse_m) {
    const int width = origin.width(), height = origin.height();
    ByteImage marks(width, height, 1);
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const tbb::blocked_range<int>& rows) {
        std::vector<std::uint8_t> steps_right(std::size_t(width), 0);
        for (int y = rows.begin(); y < rows.end(); ++y) {
            std::uint8_t* out = marks.pixel(0, y);
            mark_origins(origin, y, out);
            if (inverse_planar.empty())
                continue;
            mark_along_row(inverse_planar.pixel(0, y), width, step_inverse_m, steps_right.data(), out);
            mark_between_rows(inverse_planar, y - 1, step_inverse_m, out);
            mark_between_rows(inverse_planar, y, step_inverse_m, out);
        }
    });
    ByteImage scratch(width, height, 1);
    for (int i = 1; i < on_silhouette; ++i)
        spread(marks, scratch);
    return marks;
}

ByteImage fill_depth(const ByteImage& origin) {
    const int width = origin.width(), height = origin.height();
    constexpr auto source = std::uint8_t(PixelOrigin::source);
    ByteImage depth(width, height, 1);
    std::vector<std::uint8_t> column(std::size_t(width), 255);
    const auto down_to = [&](int y) {
        const std::uint8_t* o = origin.pixel(0, y);
        std::uint8_t* d = depth.pixel(0, y);
        for (int x = 0; x < width; ++x) {
            const std::uint8_t steps = o[x] == source ? std::uint8_t(0) : one_more(column[std::size_t(x)]);
            column[std::size_t(x)] = steps;
            d[x] = std::min(d[x], steps);
        }
    };
    std::ranges::fill(depth.samples(), std::uint8_t{255});
    for (int y = 0; y < height; ++y)
        down_to(y);
    std::ranges::fill(column, std::uint8_t{255});
    for (int y = height - 1; y >= 0; --y)
        down_to(y);
    for (int y = 0; y < height; ++y) {
        std::uint8_t* d = depth.pixel(0, y);
        if (std::all_of(d, d + width, [](std::uint8_t steps) { return steps == 0; }))
            continue;
        std::uint8_t steps = 255;
        for (int x = 0; x < width; ++x)
            d[x] = steps = std::min(d[x], one_more(steps));
        steps = 255;
        for (int x = width - 1; x >= 0; --x)
            d[x] = steps = std::min(d[x], one_more(steps));
    }
    return depth;
}

namespace {

/// One row of channels and what lies around each.
struct Neighbours {
    const std::uint8_t *here, *before, *after;
};

void widen(const Neighbours& n, std::size_t count, std::uint8_t* detail) {
    for (std::size_t i = 0; i < count; ++i) {
        const int bend = n.here[i] - (n.before[i] + n.after[i] + 1) / 2;
        detail[i] = std::max(detail[i], std::uint8_t(std::abs(bend)));
    }
}

void worst_channel(const std::vector<std::uint8_t>& rgba, int width, std::uint8_t* out) {
    const std::uint8_t* p = rgba.data();
    for (int x = 0; x < width; ++x)
        out[x] = std::max({p[4 * x], p[4 * x + 1], p[4 * x + 2]});
}

}  // namespace

Differences differences(const ByteImage& rgba, int step) {
    const int width = rgba.width(), height = rgba.height();
    const std::size_t channels = 4 * std::size_t(width), clearance = 4 * std::size_t(step);
    Differences found{contrast_of(rgba.view(), step), ByteImage(width, height, 1)};
    ByteImage along(width, height, 1);
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const tbb::blocked_range<int>& rows) {
        std::vector<std::uint8_t> finest(channels), bend(std::size_t(width), 0);
        for (int y = rows.begin(); y < rows.end(); ++y) {
            const std::uint8_t* here = rgba.pixel(0, y);
            std::ranges::fill(finest, std::uint8_t{0});
            if (y >= step && y + step < height)
                widen({here, rgba.pixel(0, y - step), rgba.pixel(0, y + step)}, channels, finest.data());
            if (channels > 2 * clearance)
                widen({here + clearance, here, here + 2 * clearance}, channels - 2 * clearance,
                      finest.data() + clearance);
            worst_channel(finest, width, bend.data());
            std::uint8_t* out = along.pixel(0, y);
            std::ranges::copy(bend, out);
            for (int x = step; x < width; ++x)
                out[x] = std::max(out[x], bend[std::size_t(x - step)]);
            for (int x = 0; x + step < width; ++x)
                out[x] = std::max(out[x], bend[std::size_t(x + step)]);
        }
    });
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const tbb::blocked_range<int>& rows) {
        for (int y = rows.begin(); y < rows.end(); ++y) {
            const std::uint8_t* a = along.pixel(0, std::max(0, y - step));
            const std::uint8_t* b = along.pixel(0, y);
            const std::uint8_t* c = along.pixel(0, std::min(height - 1, y + step));
            std::uint8_t* out = found.detail.pixel(0, y);
            for (int x = 0; x < width; ++x)
                out[x] = std::max({a[x], b[x], c[x]});
        }
    });
    return found;
}

}  // namespace equistream::plain
