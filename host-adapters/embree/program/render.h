#pragma once
/// `equistream render`: loads the scene, renders every frame that is not there yet, reports.
#include "options.h"

#include <string>

namespace equistream::embree_host {

/// Throws InputError before rendering has begun and WorkError after. An interrupt (SIGINT, SIGTERM) leaves whole
/// frames only and ends in a WorkError that says how many.
void render(const RenderOptions& options, const std::string& command);

}  // namespace equistream::embree_host
