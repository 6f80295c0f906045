#pragma once
/// How what eyes see moves by itself, pixel by pixel, for all eyes at once.
#include "picture_extrapolator.h"

#include <client/warp/gl/eye_targets.h>

#include <span>

namespace equistream::gl {

class MotionView {
public:
    MotionView();

    /// Fills texture(). `extrapolator` has extrapolated, or has at rest, what the eyes see of `source`; depth's texture
    /// is 0 where it is not known: what moves is taken to be in the middle of where its region says it may be, seen
    /// from the source's centre. Storage is kept as long as sizes stay; what comes after needs no barrier of its own.
    void find(const SourceView& source, const PictureExtrapolator& extrapolator, std::span<const EyeView> eyes,
              const EyeDepth& depth);

    /// A layer for each eye: radians a second to the right and down, and 1; or zeros, where nothing moves (GL_RGBA16F).
    GLuint texture() const { return motion_.name(); }

private:
    Program program_;
    EyeBlocks blocks_;
    Size size_;
    int eyes_ = 0;
    Texture motion_;
};

}  // namespace equistream::gl
