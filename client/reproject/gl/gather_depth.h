#pragma once
/// Engine `gather` (engine.h) on the GPU: fixed points along each pixel's ray, as gather.cpp finds them. Where the CPU
/// begins at what a pixel's neighbours found, every pixel here begins at several distances between the nearest and the
/// farthest that its tile may show.
#include "eye_depth_finder.h"
#include "source_blocks.h"

namespace equistream::gl {

class GatherDepth : public EyeDepthFinder {
public:
    explicit GatherDepth(const EngineOptions& options = {});

    void forget_source() override { knows_blocks_ = false; }
    void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) override;

private:
    Program gather_;
    SourceBlocks blocks_;
    bool knows_blocks_ = false;
};

}  // namespace equistream::gl
