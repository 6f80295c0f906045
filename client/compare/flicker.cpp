#include "flicker.h"

#include <client/warp/resample.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

/// A column of a picture that closes on itself is counted from its first on.
float column_within(const SourceGrid& grid, float u) {
    const auto width = static_cast<float>(grid.width);
    return grid.closes ? u - width * std::floor(u / width) : u;
}

/// Whether two motions undo each other, the shortest way round.
bool return_to_the_start(const SourceGrid& grid, const float* there, const float* back) {
    const auto width = static_cast<float>(grid.width);
    float across = there[0] + back[0];
    if (grid.closes)
        across -= width * std::round(across / width);
    return std::hypot(across, there[1] + back[1]) <= max_return_px;
}

}  // namespace

PastPixels::PastPixels(const ScoredPicture& truth, const ScoredPicture& truth_before) {
    if (truth.backward.empty() || truth_before.forward.empty())
        return;
    camera_ = truth.info->camera;
    const SourceLookup lookup(camera_);
    const SourceGrid& grid = lookup.grid();
    position_ = FloatImage(truth.width(), truth.height(), 2);
    seen_ = ByteImage(truth.width(), truth.height(), 1);
    tbb::parallel_for(0, truth.height(), [&](int y) {
        for (int x = 0; x < truth.width(); ++x) {
            const float* backward = truth.backward.pixel(x, y);
            const PixelPosition was{column_within(grid, static_cast<float>(x) + 0.5f + backward[0]),
                                    static_cast<float>(y) + 0.5f + backward[1]};
            if (!lookup.contains(was))
                continue;
            const Sample nearest = wrapped(grid, static_cast<int>(was.u), static_cast<int>(was.v));
            if (!return_to_the_start(grid, backward, truth_before.forward.pixel(nearest.x, nearest.y)))
                continue;
            position_.pixel(x, y)[0] = was.u;
            position_.pixel(x, y)[1] = was.v;
            *seen_.pixel(x, y) = 255;
        }
    });
}

FloatImage PastPixels::change(const FloatImage& now, const FloatImage& before) const {
    FloatImage change = now;
    if (!by_motion()) {
        for (std::size_t i = 0; i < change.samples().size(); ++i)
            change.samples()[i] -= before.samples()[i];
        return change;
    }
    const SourceLookup lookup(camera_);
    tbb::parallel_for(0, now.height(), [&](int y) {
        for (int x = 0; x < now.width(); ++x) {
            float* changed = change.pixel(x, y);
            if (*seen_.pixel(x, y) == 0) {
                std::fill_n(changed, change.channels(), 0.f);
                continue;
            }
            const float* was = position_.pixel(x, y);
            const Taps taps = lookup.taps({was[0], was[1]});
            for (std::size_t k = 0; k < taps.weight.size(); ++k)
                for (int c = 0; c < change.channels(); ++c)
                    changed[c] -= taps.weight[k] * before.pixel(taps.x[k], taps.y[k])[c];
        }
    });
    return change;
}

}  // namespace equistream
