#pragma once
/// The library's modules: shared libraries beside it, in equistream/, loaded when the first client needs them and kept.
/// Each is of the library's own version and code, or refused. Any thread.
#include <client/pipeline/modules.h>

namespace equistream {

/// Throws InputError in one line where the module is not there or is another version's.
RayModule load_ray_module();
GlModule load_gl_module();

/// What a module exports: equistream_client_module_NAME. The version must be that of the library that loads it.
template <typename Module>
struct ExportedModule {
    const char* version;
    Module functions;
};

}  // namespace equistream
