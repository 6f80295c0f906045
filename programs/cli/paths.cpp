#include "paths.h"

#include "program.h"

#include <equistream/error.h>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace equistream::cli {

namespace fs = std::filesystem;

void require_writable_file(const fs::path& file) {
    const std::string option = "--out " + file.string();
    const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
    std::error_code error;
    require(fs::is_directory(folder, error), option, "a folder that can be written to", folder.string());
    if (access(folder.c_str(), W_OK | X_OK) != 0) {
        const std::string why = std::strerror(errno);
        throw InputError(expected_found(option, "a folder that can be written to", folder.string() + ": " + why));
    }
    require(!fs::is_directory(file, error), option, "the name of a file", "a folder of this name");
}

void require_not_read(const std::string& option, const fs::path& target, const std::vector<fs::path>& read) {
    for (const fs::path& input : read) {
        std::error_code error;  // what is not there is no other's
        require(!fs::equivalent(target, input, error), option + " " + target.string(),
                "an output that is not the input", input.string());
    }
}

namespace {

bool is_or_lies_in(const fs::path& path, const fs::path& folder) {
    return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

}  // namespace

void require_apart(const std::string& option, const fs::path& target, const std::vector<fs::path>& read) {
    std::error_code error;  // what cannot be looked at is told where it is opened
    const auto full = [&](const fs::path& path) { return fs::weakly_canonical(fs::absolute(path, error), error); };
    const fs::path place = full(target);
    for (const fs::path& input : read) {
        const fs::path folder = full(input);
        require(!is_or_lies_in(place, folder), option + " " + target.string(), "an output outside the input",
                input.string());
    }
}

}  // namespace equistream::cli
