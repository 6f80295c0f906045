#pragma once
/// What the gap pixels of an eye see: 1 / planar depth of each, and of the pixels beside it. One plane of the picture's
/// size, of which only those pixels are ever written or read, so that it costs no more than the gaps do.
#include "gaps.h"

#include <client/warp/view.h>

#include <memory>
#include <mutex>
#include <vector>

namespace equistream {

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

class SeenPoints {
public:
    /// Takes the eye's depths, or, where it has none, those of the picture's coloured pixels. NaN: not known.
    void look(const EyeView& eye, const EyePicture& picture, const Gaps& gaps);

    const FloatImage& inverse_planar() const { return inverse_planar_; }
    FloatImage& inverse_planar() { return inverse_planar_; }

private:
    FloatImage inverse_planar_;
};

/// Radial over planar depth at a pixel's centre.
inline float radial_over_planar(const PerspectiveCamera& camera, int x, int y) {
    const float inverse_focal = float(1 / camera.focal_px());
    const float a = (float(x) + 0.5f - 0.5f * float(camera.width)) * inverse_focal;
    const float b = (float(y) + 0.5f - 0.5f * float(camera.height)) * inverse_focal;
    return std::sqrt(1 + a * a + b * b);
}

}  // namespace equistream
