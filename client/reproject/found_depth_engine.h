#pragma once
/// Engines made of a DepthFinder and the colour lookup of `surface`.
#include <equistream_client/engine.h>

namespace equistream {

/// `name`: splat, gather, mesh, mesh-plain or lean.
std::unique_ptr<Engine> make_found_depth_engine(std::string_view name, const EngineOptions& options);

}  // namespace equistream
