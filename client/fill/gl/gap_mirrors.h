#pragma once
/// What gap pixels see in mirrors and glass, by the mask of some picture, so that no other picture's colours are taken
/// where that one shows something else in them from its own place (gap_resample.h). For all eyes at once.
#include "gap_resample.h"

#include <client/reflections/gl/specular_textures.h>

namespace equistream::gl {

class GapMirrors {
public:
    GapMirrors();

    /// Of all gaps whose surface `teller` sees. Returns GapTargets::image_behind, good until the next call; 0 where it
    /// does not tell.
    GLuint find(const SpecularSource& teller, const GapTargets& to);

private:
    Program program_;
    EyeBlocks blocks_;
    Size size_;
    int eyes_ = 0;
    Texture image_behind_;
};

}  // namespace equistream::gl
