#include "fill.h"

#include <equistream/elapsed.h>

#include <cassert>

namespace equistream {

FilledCounts fill_gaps(const FillLadder& ladder, const EyeView& eye, EyePicture& picture) {
    std::vector<double> unused(ladder.size());
    return fill_gaps(ladder, eye, picture, unused);
}

FilledCounts fill_gaps(const FillLadder& ladder, const EyeView& eye, EyePicture& picture, std::span<double> rung_ms) {
    assert(rung_ms.size() == ladder.size());
    FilledCounts filled;
    Gaps gaps(picture.origin.view());
    for (std::size_t i = 0; i < ladder.size(); ++i) {
        const auto start = Clock::now();
        filled.emplace_back(ladder[i]->name(), ladder[i]->fill(eye, picture, gaps));
        rung_ms[i] = milliseconds_since(start);
    }
    return filled;
}

}  // namespace equistream
