#pragma once
/// What a host's target has to be, so that nothing fails once it is drawn into.
#include <client/gpu/objects.h>
#include <client/pipeline/modules.h>

#include <string>

namespace equistream::gl {

/// Throws InputError where the framebuffer takes no colours, or a texture has another format or fewer texels than
/// `size`. `name` stands before what is said.
void require_host_target(const GlHostTarget& target, Size size, bool has_confidence, const std::string& name);

}  // namespace equistream::gl
