#include "requirements.h"

#include <epoxy/gl.h>

namespace equistream::gl {

std::string missing_requirement() {
    constexpr int min_version = 45;
    if (epoxy_gl_version() < min_version)
        return "version 4.5";
    for (const char* extension : {"GL_ARB_shader_viewport_layer_array", "GL_ARB_indirect_parameters"})
        if (!epoxy_has_gl_extension(extension))
            return extension;
    return "";
}

}  // namespace equistream::gl
