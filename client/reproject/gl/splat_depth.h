#pragma once
/// Engine `splat` (engine.h) on the GPU, its first half: how far away is what the eyes see? Every sample of the source
/// is drawn forward, by atomic maxima of inverse depth in place of an occlusion-compatible order: work groups have
/// none.
#include "eye_blocks.h"
#include "eye_depth_layers.h"
#include "lattice_textures.h"
#include "source_textures.h"

#include <equistream_client/engine.h>

#include <span>

namespace equistream::gl {

class SplatDepth {
public:
    explicit SplatDepth(const EngineOptions& options = {});

    /// Finds the depth of eyes of one size, whose depth_m is not read; `source` has depth. What comes after may sample
    /// depth() without a barrier of its own.
    void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes);
    void forget_gaps(const EyeTargets& targets) const { layers_.forget_gaps(targets); }
    EyeDepth depth() const { return layers_.depth(); }

private:
    EngineOptions options_;
    Program splat_, end_;
    EyeBlocks eye_blocks_;
    LatticeTextures lattice_;
    EyeDepthLayers layers_;
    Texture nearest_;  ///< empty between calls
};

}  // namespace equistream::gl
