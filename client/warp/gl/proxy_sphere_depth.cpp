#include "proxy_sphere_depth.h"

#include <client/warp/proxy_sphere.h>

namespace equistream::gl {

ProxySphereDepth::ProxySphereDepth(const EngineOptions& options)
    : EyeDepthFinder(options, {.needs_depth = false, .only_seen = false, .is_known = false}),
      leave_sphere_({{GL_COMPUTE_SHADER, "proxy_sphere_depth.glsl"}}) {}

void ProxySphereDepth::find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) {
    if (radius_m_ == 0)
        radius_m_ = float(proxy_radius_m(view, options_));
    const Size size{eyes.front().camera.width, eyes.front().camera.height};
    layers_.size_for(size, int(eyes.size()));
    bind(view, source, eyes);
    layers_.bind(0);
    leave_sphere_.set("radius_m", radius_m_);
    leave_sphere_.dispatch(size, int(eyes.size()));
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

std::unique_ptr<EyeDepthFinder> make_proxy_sphere_depth(const EngineOptions& options) {
    return std::make_unique<ProxySphereDepth>(options);
}

}  // namespace equistream::gl
