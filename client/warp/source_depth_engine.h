#pragma once
/// Engines made of a EyeDepthFromSource and the colour lookup of `eye-depth`.
#include "engine.h"

namespace equistream {

/// `name`: splat, mesh, mesh-plain or proxy-sphere.
std::unique_ptr<Engine> make_source_depth_engine(std::string_view name, const EngineOptions& options);

}  // namespace equistream
