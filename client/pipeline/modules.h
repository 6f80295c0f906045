#pragma once
/// What the pipeline takes from Embree and from OpenGL, and its OpenGL back end.
#include "covering_view.h"

#include <client/depth/depth_source.h>
#include <client/receive/receive.h>
#include <client/reflections/specular.h>
#include <client/warp/view.h>
#include <scenes/library/scene.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace equistream {

// The pipeline's OpenGL back end as the client library takes it from its module. One context is current in
// every call, the destructor's too. Its state comes back, but for what equistream/client.h lists.

struct GlEyesSettings {
    const SceneDescription* scene = nullptr;  ///< whose geometry gives depth; null: the frame's own does
    double box_radius_m = 0;
    std::string engine;
    std::string fill;
    MirrorTreatment mirrors = MirrorTreatment::images;
    bool confidence = false;
    bool by_depth = true;
    double exposure_stops = 0;  ///< of HDR frames
};

/// As es_gl_textures.
struct GlEyesTextures {
    std::uint32_t colour = 0, origin = 0, inverse_depth = 0, confidence = 0;
    float inverse_depth_scale = 0;
};

/// As es_gl_target. Textures may be 0: not wanted.
struct GlHostTarget {
    std::uint32_t framebuffer = 0;
    int x = 0, y = 0;
    std::uint32_t origin = 0, depth_m = 0, confidence = 0;
};

class GlEyes {
public:
    virtual ~GlEyes() = default;
    virtual void show(std::shared_ptr<const ReceivedFrame> frame) = 0;
    /// Two eyes of one size. Returns by how much moving objects are shown later: as wanted, or 0 where that cannot be.
    virtual double render(std::span<const EyeView> eyes, double extrapolation_s) = 0;
    /// Of the last render. Waits for the GPU. `depth_m`: radial, NaN where it is not known.
    virtual void download(int eye, EyePicture& picture, FloatImage& depth_m) = 0;
    /// Throws InputError where the framebuffer takes no colours, or a texture has another format or fewer texels.
    /// `name` stands before what is said.
    virtual void require_target(const GlHostTarget& target, int width, int height, const std::string& name) const = 0;
    /// Copies a part of an eye's picture, the right way up for a window, without another encoding. What is known of its
    /// pixels goes to the textures, from the first texel on.
    virtual void write(int eye, const ViewPart& part, const GlHostTarget& to) = 0;
    virtual GlEyesTextures textures() const = 0;
};

using MakeGlEyes = std::unique_ptr<GlEyes> (*)(const GlEyesSettings& settings);

// What the pipeline takes from Embree and from OpenGL. Programs link them; the client library loads them on demand
// (client/abi/module_loading.h). A null function: that module is not there.

/// Casts rays into the scene's geometry.
struct RayModule {
    std::unique_ptr<DepthSource> (*depth)(const SceneDescription& scene) = nullptr;
    /// Loads on a thread of its own.
    std::unique_ptr<GeometryColour> (*colour)(const SceneDescription& scene) = nullptr;
};

/// Draws the scene's geometry without a window.
struct DrawnDepth {
    std::unique_ptr<DepthSource> source;
    std::string driver;
};
using MakeDrawnDepth = DrawnDepth (*)(const SceneDescription& scene, bool cube, double box_radius_m);

struct GeometryModules {
    RayModule ray;
    MakeDrawnDepth drawn = nullptr;
};

/// Whatever OpenGL does for a client.
struct GlModule {
    MakeDrawnDepth depth = nullptr;
    MakeGlEyes eyes = nullptr;
};

}  // namespace equistream
