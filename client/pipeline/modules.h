#pragma once
/// What the pipeline takes from Embree and from OpenGL. Programs link them; the client library loads them on demand
/// (client/abi/module_loading.h). A null function: that module is not there.
#include "gl_eyes.h"

#include <client/depth/depth_source.h>
#include <client/depth/geometry_colour.h>
#include <scenes/library/scene.h>

#include <memory>
#include <string>

namespace equistream {

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
