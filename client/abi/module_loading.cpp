#include "module_loading.h"

#include <equistream/error.h>

#include <dlfcn.h>

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>

namespace equistream {

namespace {

namespace fs = std::filesystem;

/// The folder of modules that belongs to this very library: beside it where it is installed, else in the build tree.
fs::path module_folder() {
    static const char anchor = 0;
    Dl_info here{};
    if (dladdr(&anchor, &here) == 0 || here.dli_fname == nullptr)
        throw WorkError("libequistream_client: the system does not say where this library is installed");
    std::error_code unknown;
    const fs::path library = fs::canonical(here.dli_fname, unknown);
    return (unknown ? fs::path(here.dli_fname) : library).parent_path() / "equistream";
}

template <typename Module>
Module load(const char* name, const char* what) {
    const fs::path file = module_folder() / (std::string("libequistream_client_") + name + ".so");
    // Never unloaded: what it made may outlive every client.
    void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
        const char* why = dlerror();
        throw InputError(
            expected_found(std::string(what), "the module " + file.string(), why != nullptr ? why : "none"));
    }
    const std::string symbol = std::string("equistream_client_module_") + name;
    const auto* exported = static_cast<const ExportedModule<Module>*>(dlsym(library, symbol.c_str()));
    if (exported == nullptr || std::string(exported->code) != code_identity())
        throw InputError(expected_found(file.string(),
                                        std::string("a module from the same build as this library, ") + code_identity(),
                                        exported == nullptr ? "none" : exported->code));
    return exported->functions;
}

template <typename Module>
Module loaded_once(const char* name, const char* what) {
    static std::mutex mutex;
    static std::optional<Module> module;
    const std::lock_guard lock(mutex);
    if (!module)
        module = load<Module>(name, what);
    return *module;
}

}  // namespace

RayModule load_ray_module() {
    return loaded_once<RayModule>("embree", "scene");
}

GlModule load_gl_module() {
    return loaded_once<GlModule>("gl", "ES_BACKEND_OPENGL");
}

}  // namespace equistream
