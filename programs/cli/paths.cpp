#include "paths.h"

#include "program.h"

#include <unistd.h>

#include <system_error>

namespace equistream::cli {

namespace fs = std::filesystem;

void require_writable_file(const fs::path& file) {
    const std::string option = "--out " + file.string();
    const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
    std::error_code error;
    require(fs::is_directory(folder, error) && access(folder.c_str(), W_OK | X_OK) == 0, option,
            "a folder that can be written to", folder.string());
    require(!fs::is_directory(file, error), option, "the name of a file", "a folder of this name");
}

void require_not_read(const std::string& option, const fs::path& target, const std::vector<fs::path>& read) {
    for (const fs::path& input : read) {
        std::error_code error;  // what is not there is no other's
        require(!fs::equivalent(target, input, error), option + " " + target.string(),
                "another place than what is read", input.string());
    }
}

}  // namespace equistream::cli
