#pragma once
/// Turns flat views of depth into the depth of a source's samples (OpenGL).
#include "sphere_views.h"

#include <client/warp/gl/pixel_list.h>
#include <client/warp/gl/source_textures.h>

namespace equistream::gl {

class SphereDepth {
public:
    /// Interpolated depth stays within `error_rad` by the bound (bound.h), for eyes in a ball of this radius.
    SphereDepth(double box_radius_m, double error_rad);

    /// Writes the depth of those of `views.samples` that one of `views.views` shows into the source's depth texture,
    /// from the pass's layers that start with `first_layer`. Other samples keep what they had.
    void resolve(const DepthPass& pass, int first_layer, const SphereViews& views, const Pose& source_pose,
                 SourceTextures& source);

private:
    /// For so many views.
    struct Passes {
        explicit Passes(std::size_t views);
        Program first;   ///< every sample, where the rule is simple
        Program listed;  ///< the others
    };

    float box_radius_m_, error_;
    Passes one_view_, faces_;
    PixelList list_;
    Buffer views_;
};

}  // namespace equistream::gl
