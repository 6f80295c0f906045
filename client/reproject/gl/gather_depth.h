#pragma once
/// Engine `gather` (engine.h) on the GPU, its first half: how far away is what the eyes see? Fixed points along each
/// pixel's ray, as gather.cpp finds them; where the CPU begins at what a pixel's neighbours found, every pixel here
/// begins at several distances between the nearest and the farthest that its tile may show.
#include "eye_blocks.h"
#include "eye_depth_layers.h"
#include "lattice_textures.h"
#include "source_textures.h"

#include <equistream_client/engine.h>

#include <span>

namespace equistream::gl {

class GatherDepth {
public:
    explicit GatherDepth(const EngineOptions& options = {});

    /// The source's depth is another from now on.
    void forget_source() { knows_blocks_ = false; }
    /// Finds the depth of eyes of one size, whose depth_m is not read; `source` has depth. What comes after may sample
    /// depth() without a barrier of its own.
    void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes);
    void forget_gaps(const EyeTargets& targets) const { layers_.forget_gaps(targets); }
    EyeDepth depth() const { return layers_.depth(); }

private:
    void find_blocks();

    EngineOptions options_;
    Program find_blocks_, gather_;
    EyeBlocks eye_blocks_;
    LatticeTextures lattice_;
    EyeDepthLayers layers_;
    Buffer blocks_;
    Size block_grid_;
    bool knows_blocks_ = false;
};

}  // namespace equistream::gl
