#pragma once
/// Which pixels of an eye's picture nobody has coloured, as runs along rows: found once, then only those are visited.
#include <equistream/camera.h>
#include <equistream/image.h>

#include <client/warp/view.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
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
    bool empty() const { return spans_.empty(); }
    /// Looks again, but only where there were gaps.
    void narrow(ImageView<const std::uint8_t> origin);

private:
    std::vector<GapSpan> spans_;
};

// Gaps wide enough for a coarse picture to tell something of them.

/// Of gaps in a picture `width` pixels wide, those whose connected component, corners counted, holds a square of `side`
/// pixels a side. All of them for a side of 1.
Gaps wide_gaps(const Gaps& gaps, int width, int side);

/// Which squares are wide enough for a source: half of its pixel, in the eye's, where both look straight ahead. By
/// trial: in gaps of less, colours of full resolution around them are mostly nearer the truth (docs/decisions/0004).
int wide_gap_side(const PerspectiveCamera& eye, const Camera& source);

/// Things that are costly to make, lent to one fill at a time.
template <typename Thing>
class ObjectPool {
public:
    std::unique_ptr<Thing> acquire() {
        const std::scoped_lock lock(mutex_);
        if (pool_.empty())
            return std::make_unique<Thing>();
        std::unique_ptr<Thing> thing = std::move(pool_.back());
        pool_.pop_back();
        return thing;
    }
    void release(std::unique_ptr<Thing> thing) {
        const std::scoped_lock lock(mutex_);
        pool_.push_back(std::move(thing));
    }

private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<Thing>> pool_;
};

/// What the gap pixels of an eye see: 1 / planar depth of each, and of the pixels beside it. One plane of the picture's
/// size, of which only those pixels are ever written or read, so that it costs no more than the gaps do.
struct SeenPoints {
    /// Takes the eye's depths, or, where it has none, those of the picture's coloured pixels. NaN: not known.
    void look(const EyeView& eye, const EyePicture& picture, const Gaps& gaps);

    FloatImage inverse_planar;
};

/// Radial over planar depth at a pixel's centre.
inline float radial_over_planar(const PerspectiveCamera& camera, int x, int y) {
    const float inverse_focal = float(1 / camera.focal_px());
    const float a = (float(x) + 0.5f - 0.5f * float(camera.width)) * inverse_focal;
    const float b = (float(y) + 0.5f - 0.5f * float(camera.height)) * inverse_focal;
    return std::sqrt(1 + a * a + b * b);
}

// How far away the background of a gap is, where nobody knows what its pixels see. What a source did not see lies
// behind the edge of something that it saw; moving from the source to the eye lays the gap open between that edge and
// the background, along the eye's epipolar lines.

/// Gives each gap pixel of `background_m` (the picture's size) the larger of the depths at the two ends of its run
/// along its row or its column, whichever is nearer to its epipolar line; NaN where the run ends at the picture's
/// borders only. `epipole`: the source's position from the eye, in the eye's axes; 0: the largest of all four ends.
void find_background(const EyeView& eye, const EyePicture& picture, const Gaps& gaps, const glm::dvec3& epipole,
                     FloatImage& background_m);

}  // namespace equistream
