#pragma once
/// Engine `proxy-sphere` (engine.h) on the GPU: rays as far as a sphere of one radius around the source.
#include "eye_depth_finder.h"

namespace equistream::gl {

class ProxySphereDepth : public EyeDepthFinder {
public:
    explicit ProxySphereDepth(const EngineOptions& options = {});

    void forget_source() override { radius_m_ = 0; }
    void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) override;

private:
    Program leave_sphere_;
    float radius_m_ = 0;  ///< 0: not found yet
};

}  // namespace equistream::gl
