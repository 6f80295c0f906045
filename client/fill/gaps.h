#pragma once
/// Which pixels of an eye's picture nobody has coloured, as runs along rows: found once, then only those are visited.
#include <equistream/image.h>

#include <cstdint>
#include <span>
#include <vector>

namespace equistream {

/// Columns begin to end - 1 of a row, every one of them a gap.
struct GapSpan {
    int y = 0, begin = 0, end = 0;
};

class Gaps {
public:
    Gaps() = default;
    /// Looks through all of `origin` (PixelOrigin, 1 channel).
    explicit Gaps(ImageView<const std::uint8_t> origin);
    /// Of spans as spans() gives them.
    explicit Gaps(std::vector<GapSpan> spans);

    /// Rows from the top down, spans of a row from left to right; they neither touch nor overlap.
    std::span<const GapSpan> spans() const { return spans_; }
    /// Those of rows first to end - 1.
    std::span<const GapSpan> rows(int first, int end) const;
    std::int64_t count() const { return count_; }
    bool empty() const { return spans_.empty(); }
    /// Looks again, but only where there were gaps.
    void narrow(ImageView<const std::uint8_t> origin);

private:
    void add(int y, int begin, int end);

    std::vector<GapSpan> spans_;
    std::int64_t count_ = 0;
};

}  // namespace equistream
