#pragma once
/// Fill passes `hidden`, `earlier` and `small` (fill.h) on the GPU, for all eyes at once: gap pixels take what
/// they see from another picture, by the eyes' depth: their own, or what found_depth.h finds. What
/// mirrors and glass show is not on them: such a pixel is coloured only where the picture shows the same in them from
/// its own place, within the budget.
#include "gap_tiles.h"

#include <client/warp/gl/eye_blocks.h>
#include <client/warp/gl/source_textures.h>

#include <span>

namespace equistream::gl {

/// The eyes whose gaps a fill pass fills. What comes after needs no barrier of its own, as in Resample.
struct GapTargets {
    std::span<const EyeView> eyes;  ///< their depth_m is not read
    const EyeDepth& depth;
    /// Of the targets as they are, or as they were before some of their gaps were filled.
    const GapTiles& gaps;
    const EyeTargets& targets;
    /// How far behind the surface that a gap pixel sees its image in a mirror lies (GapMirrors), a layer for each eye;
    /// 0: mirrors are looked up like any surface.
    GLuint image_behind = 0;
};

/// The picture to look up in: what it is of, and its pixels, which are those of `view`.
struct OtherPicture {
    const SourceView& view;
    const SourceTextures& textures;
    PixelOrigin mark = PixelOrigin::gap;
};

class GapResample {
public:
    GapResample();

    /// By the picture's depth, or, of a small view that has none, by direction alone; others fill nothing then.
    void fill(const OtherPicture& from, const GapTargets& to);

private:
    Program program_;
    EyeBlocks blocks_;
};

/// Binds what gap_resample.glsl reads and writes of the eyes, and runs a program made of it.
void run_gap_resample(const Program& program, const GapTargets& to, PixelOrigin mark);

}  // namespace equistream::gl
