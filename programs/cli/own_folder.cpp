#include "own_folder.h"

namespace equistream::cli {

std::filesystem::path own_folder() {
    std::error_code error;
    return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace equistream::cli
