#pragma once
/// What an engine finds on the GPU that eyes of one size see: inverse planar depth, a layer each; NaN where nothing was
/// found.
#include "eye_targets.h"

namespace equistream::gl {

class EyeDepthLayers {
public:
    EyeDepthLayers();

    /// Storage is kept as long as the size stays. Whether it did.
    bool size_for(Size size, int eyes);
    /// Image unit `unit` is the layers, to be written.
    void bind(GLuint unit) const;
    /// Makes unknown what gap pixels of the targets see.
    void forget_gaps(const EyeTargets& targets) const;

    Size size() const { return size_; }
    int eyes() const { return eyes_; }
    EyeDepth depth() const { return {depth_.name(), 1}; }

private:
    Program forget_gaps_;
    Size size_;
    int eyes_ = 0;
    Texture depth_;
};

}  // namespace equistream::gl
