#include "gaps.h"

#include <client/warp/view.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

namespace equistream {

namespace {

constexpr std::uint64_t low_bits = 0x7f7f7f7f7f7f7f7full;

/// The top bit of every byte of the word that is 0 (a gap), and no other bit.
std::uint64_t gap_bytes(std::uint64_t word) {
    return ~(((word & low_bits) + low_bits) | word | low_bits);
}

std::uint64_t word_at(const std::uint8_t* bytes) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes, sizeof word);
    return word;
}

/// The first pixel from `x` on that is a gap, or that is none; `end` if there is no such.
int next(const std::uint8_t* row, int x, int end, bool gap) {
    const std::uint64_t flip = gap ? 0 : ~low_bits;
    for (; x + 8 <= end; x += 8)
        if (const std::uint64_t found = gap_bytes(word_at(row + x)) ^ flip; found != 0)
            return x + std::countr_zero(found) / 8;
    while (x < end && (row[x] == std::uint8_t(PixelOrigin::gap)) != gap)
        ++x;
    return x;
}

/// Calls found(begin, end) for each run of gaps in [begin, end).
template <typename Found>
void runs(const std::uint8_t* row, int begin, int end, const Found& found) {
    for (int x = next(row, begin, end, true); x < end;) {
        const int stop = next(row, x, end, false);
        found(x, stop);
        x = next(row, stop, end, true);
    }
}

static_assert(std::uint8_t(PixelOrigin::gap) == 0 && std::endian::native == std::endian::little);

}  // namespace

Gaps::Gaps(ImageView<const std::uint8_t> origin) {
    for (int y = 0; y < origin.height; ++y)
        runs(origin.row(y), 0, origin.width, [&](int begin, int end) { spans_.push_back({y, begin, end}); });
}

Gaps::Gaps(std::vector<GapSpan> spans) : spans_(std::move(spans)) {
    assert(std::ranges::adjacent_find(spans_, [](const GapSpan& a, const GapSpan& b) {
               return b.y < a.y || (b.y == a.y && b.begin <= a.end);
           }) == spans_.end());
}

std::span<const GapSpan> Gaps::rows(int first, int end) const {
    const auto from = std::ranges::lower_bound(spans_, first, {}, &GapSpan::y);
    return {from, std::ranges::lower_bound(from, spans_.end(), end, {}, &GapSpan::y)};
}

void Gaps::narrow(ImageView<const std::uint8_t> origin) {
    const std::vector<GapSpan> before = std::exchange(spans_, {});
    spans_.reserve(before.size());
    for (const GapSpan& span : before)
        runs(origin.row(span.y), span.begin, span.end, [&](int begin, int end) {
            spans_.push_back({span.y, begin, end});
        });
}

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

void SeenPoints::look(const EyeView& eye, const EyePicture& picture, const Gaps& gaps) {
    const int width = picture.origin.width();
    const int height = picture.origin.height();
    if (inverse_planar.width() != width || inverse_planar.height() != height)
        inverse_planar = FloatImage(width, height, 1);
    const bool own = eye.depth_m.data == nullptr && !picture.depth_m.empty();
    const ImageView<const float> depth_m = own ? picture.depth_m.view() : eye.depth_m;
    const auto look_at = [&](int y, int begin, int end) {
        begin = std::max(begin, 0);
        end = std::min(end, width);
        float* inverse = inverse_planar.pixel(0, y);
        if (depth_m.data == nullptr)
            return std::fill(inverse + begin, inverse + end, std::numeric_limits<float>::quiet_NaN());
        const float* depth = depth_m.row(y);
        for (int x = begin; x < end; ++x)
            inverse[x] = depth[x] > 0 ? radial_over_planar(eye.camera, x, y) / depth[x]
                                      : std::numeric_limits<float>::quiet_NaN();
    };
    // Each task writes rows of its own, whosever neighbours their pixels are.
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const tbb::blocked_range<int>& rows) {
        for (const GapSpan& span : gaps.rows(rows.begin() - 1, rows.end() + 1)) {
            if (span.y >= rows.begin() && span.y < rows.end())
                look_at(span.y, span.begin - 1, span.end + 1);
            if (span.y > rows.begin())
                look_at(span.y - 1, span.begin, span.end);
            if (span.y + 1 < rows.end())
                look_at(span.y + 1, span.begin, span.end);
        }
    });
}

namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

/// The farther of two ends, of which either may be unknown.
float farther(float a, float b) {
    return std::fmax(a, b);
}

class Background {
public:
    Background(const EyeView& eye, const EyePicture& picture, const glm::dvec3& epipole, FloatImage& out)
        : eye_(eye), picture_(picture), epipole_(epipole), out_(out) {}

    void run(std::span<const GapSpan> spans) {
        // First the nearest end above, then, from the bottom up, the one below and the row's own.
        for (const GapSpan& span : spans)
            for (int x = span.begin; x < span.end; ++x)
                out_.pixel(x, span.y)[0] = above(x, span.y);
        below_.assign(std::size_t(out_.width()), unknown);
        for (auto span = spans.rbegin(); span != spans.rend(); ++span) {
            const int row = span->y;
            const float left = span->begin > 0 ? picture_.depth_m.pixel(span->begin - 1, row)[0] : unknown;
            const float right = span->end < out_.width() ? picture_.depth_m.pixel(span->end, row)[0] : unknown;
            for (int x = span->begin; x < span->end; ++x) {
                if (!open(x, row + 1))
                    below_[std::size_t(x)] = row + 1 < out_.height() ? picture_.depth_m.pixel(x, row + 1)[0] : unknown;
                settle(x, row, farther(left, right), below_[std::size_t(x)]);
            }
        }
    }

private:
    bool open(int x, int y) const {
        return y >= 0 && y < out_.height() && picture_.origin.pixel(x, y)[0] == std::uint8_t(PixelOrigin::gap);
    }

    /// The depth of the run's end above, taken over from the gap pixel there.
    float above(int x, int y) const {
        if (y == 0)
            return unknown;
        return open(x, y - 1) ? out_.pixel(x, y - 1)[0] : picture_.depth_m.pixel(x, y - 1)[0];
    }

    void settle(int x, int y, float in_row, float below) {
        float& depth = out_.pixel(x, y)[0];
        const float in_column = farther(depth, below);
        // The epipolar line's direction here, up to scale: the derivative of the pixel as the eye moves.
        const double a = x + 0.5 - 0.5 * eye_.camera.width, b = y + 0.5 - 0.5 * eye_.camera.height;
        const double f = eye_.camera.focal_px();
        const double along_x = std::abs(f * epipole_.x + a * epipole_.z);
        const double along_y = std::abs(-f * epipole_.y + b * epipole_.z);
        if (along_x == along_y)
            depth = farther(in_row, in_column);
        else if (along_x > along_y)
            depth = std::isnan(in_row) ? in_column : in_row;
        else
            depth = std::isnan(in_column) ? in_row : in_column;
    }

    const EyeView& eye_;
    const EyePicture& picture_;
    glm::dvec3 epipole_;
    FloatImage& out_;
    std::vector<float> below_;
};

}  // namespace

void find_background(const EyeView& eye, const EyePicture& picture, const Gaps& gaps, const glm::dvec3& epipole,
                     FloatImage& background_m) {
    if (background_m.width() != picture.origin.width() || background_m.height() != picture.origin.height())
        background_m = FloatImage(picture.origin.width(), picture.origin.height(), 1);
    Background(eye, picture, epipole, background_m).run(gaps.spans());
}

}  // namespace equistream
