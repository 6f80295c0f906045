#pragma once
/// Engines that look each pixel of the eye up in the source: by its direction, or by the eye's own depth.
#include "engine.h"

namespace equistream {

/// `name`: rotation or eye-depth.
std::unique_ptr<Engine> make_resample_engine(std::string_view name, const EngineOptions& options);

}  // namespace equistream
