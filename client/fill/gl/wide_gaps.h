#pragma once
/// Gaps wide enough for a coarse picture to tell something of them (fill/wide_gaps.h), found on the GPU.
#include "gap_tiles.h"

namespace equistream::gl {

class WideGaps {
public:
    WideGaps();

    /// Of gaps of the targets, those whose connected component, corners counted, holds a square of `side` pixels a
    /// side. Storage is kept as long as the targets' size stays.
    void find(const GapTiles& gaps, const EyeTargets& targets, int side);
    /// For shaders that include wide_gaps.glsl: binds storage 2 and 3.
    void bind() const;

private:
    void size_for(const EyeTargets& targets);

    Program start_, join_, mark_;
    Size size_;
    int eyes_ = 0;
    Buffer parents_, wide_roots_;
};

}  // namespace equistream::gl
