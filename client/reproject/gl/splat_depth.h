#pragma once
/// Engine `splat` (engine.h) on the GPU: every sample of the source is drawn forward, by atomic maxima of inverse depth
/// in place of an occlusion-compatible order: work groups have none.
#include "eye_depth_finder.h"

namespace equistream::gl {

class SplatDepth : public EyeDepthFinder {
public:
    explicit SplatDepth(const EngineOptions& options = {});

    void forget_source() override {}
    void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) override;

private:
    Program splat_, end_;
    Texture nearest_;  ///< empty between calls
};

}  // namespace equistream::gl
