#pragma once
/// Where the running program lies: the others lie beside it. In a header: the dispatcher links nothing of this folder.
#include <equistream/error.h>

#include <sys/auxv.h>

#include <filesystem>
#include <string>
#include <system_error>

namespace equistream::cli {

/// Where there is no /proc, as in some sandboxes, by the path that the system started the program by. Throws WorkError:
/// a path that does not say the folder would lead into the current one. `link` is another one in tests.
inline std::filesystem::path own_folder(const char* link = "/proc/self/exe") {
    std::error_code error;
    std::filesystem::path program = std::filesystem::read_symlink(link, error);
    if (error)
        program = std::filesystem::canonical(reinterpret_cast<const char*>(getauxval(AT_EXECFN)), error);
    if (error)
        throw WorkError(std::string("the folder of this program cannot be found (") + error.message() +
                        "): mount /proc, or start the program by its full path");
    return program.parent_path();
}

}  // namespace equistream::cli
