#include "gaps.h"

#include <client/warp/view.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
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
        runs(origin.row(y), 0, origin.width, [&](int begin, int end) { add(y, begin, end); });
}

Gaps::Gaps(std::vector<GapSpan> spans) : spans_(std::move(spans)) {
    assert(std::ranges::adjacent_find(spans_, [](const GapSpan& a, const GapSpan& b) {
               return b.y < a.y || (b.y == a.y && b.begin <= a.end);
           }) == spans_.end());
    for (const GapSpan& span : spans_)
        count_ += span.end - span.begin;
}

std::span<const GapSpan> Gaps::rows(int first, int end) const {
    const auto from = std::ranges::lower_bound(spans_, first, {}, &GapSpan::y);
    return {from, std::ranges::lower_bound(from, spans_.end(), end, {}, &GapSpan::y)};
}

void Gaps::narrow(ImageView<const std::uint8_t> origin) {
    const std::vector<GapSpan> before = std::exchange(spans_, {});
    spans_.reserve(before.size());
    count_ = 0;
    for (const GapSpan& span : before)
        runs(origin.row(span.y), span.begin, span.end, [&](int begin, int end) { add(span.y, begin, end); });
}

void Gaps::add(int y, int begin, int end) {
    spans_.push_back({y, begin, end});
    count_ += end - begin;
}

}  // namespace equistream
