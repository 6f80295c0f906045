#pragma once
/// State that passes which draw rely on.
#include "objects.h"

namespace equistream::gl {

/// Nothing keeps a pass that has no depth buffer from writing all pixels that it covers.
void write_all_pixels();

// All state that passes rely on which draw into a depth buffer of near / planar depth (from 0, infinitely far, to 1).

/// Clip control, the depth test, its function and depth clamping are as before when it goes.
class DrawingState {
public:
    /// What is nearer than depth 1 is cut off, or drawn at 1.
    enum class Near { clipped, clamped };

    explicit DrawingState(GLenum depth_function, Near near = Near::clipped);
    ~DrawingState();
    DrawingState(const DrawingState&) = delete;
    DrawingState& operator=(const DrawingState&) = delete;

private:
    GLboolean has_depth_test_, has_depth_clamp_;
    GLint clip_origin_ = 0, clip_depth_ = 0, depth_function_ = 0;
};

}  // namespace equistream::gl
