#pragma once
/// The `spread` rung (fill/spread_rung.h) on the GPU, for all eyes at once: a work group for each eye, layer after
/// layer, so that nobody needs to know beforehand how many layers there are.
#include "gap_look_up.h"

namespace equistream::gl {

class Spread {
public:
    Spread();

    /// Colours the gaps of all eyes: within surfaces first, by the eyes' own depth, then whatever is left;
    /// `to.depth.texture` 0: all depths are alike. What comes after needs no barrier of its own, as in LookUp.
    void fill(const GapTargets& to);

private:
    void size_for(const EyeTargets& targets);
    void spread(const GapTargets& to, bool across_surfaces) const;

    Program list_, spread_;
    EyeBlocks blocks_;
    Size size_;
    int eyes_ = 0;
    Buffer states_, lists_;
};

}  // namespace equistream::gl
