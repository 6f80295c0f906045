#pragma once
/// The library's modules: shared libraries beside it, in equistream/, loaded when the first client needs them and kept.
/// C++ objects pass between them, so what both are made of must be of the same code, or the module is refused. Any
/// thread.
#include <client/pipeline/modules.h>

namespace equistream {

/// Throws InputError in one line where the module is not there or of other code.
RayModule load_ray_module();
GlModule load_gl_module();

/// Of the code that the library and its modules share (CodeIdentity.cmake).
const char* code_identity();

/// What a module exports: equistream_client_module_NAME.
template <typename Module>
struct ExportedModule {
    const char* code;
    Module functions;
};

}  // namespace equistream
