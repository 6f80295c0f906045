#include <equistream/writable_folder.h>

#include <equistream/error.h>

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace equistream {

namespace fs = std::filesystem;

void require_writable_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    std::string why = error ? error.message() : "";
    if (!error && access(folder.c_str(), W_OK | X_OK) != 0)
        why = std::strerror(errno);
    if (!error && !fs::is_directory(folder))
        why = "not a folder";
    if (!why.empty())
        throw InputError(expected_found(folder.string(), "a folder that can be written to", why));
}

}  // namespace equistream
