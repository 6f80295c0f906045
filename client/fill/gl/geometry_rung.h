#pragma once
/// The `geometry` rung (fill/geometry_rung.h) on the GPU, for all eyes at once: which triangle a pixel shows is known
/// from the depth pass that drew the eyes.
#include "gap_look_up.h"
#include "surface_colours.h"

#include "../../depth/gl/depth_pass.h"

namespace equistream::gl {

class GeometryRung {
public:
    /// Of the model that passes are made of, with shading.
    explicit GeometryRung(const SceneModel& model);

    /// Colours gaps of all eyes. The first layers of `drawn` show them, as they are where its transforms are. What
    /// comes after needs no barrier of its own, as in LookUp.
    void fill(const DepthPass& drawn, const GapTargets& to);

private:
    void size_for(const GapTargets& to);
    void shade(const DepthPass& drawn, const GapTargets& to);

    SurfaceColours colours_;
    Program wanted_, shade_, fill_;
    EyeBlocks blocks_;
    Size size_;
    int eyes_ = 0;
    Texture wanted_tiles_, surfaces_seen_;
};

}  // namespace equistream::gl
