#include "scratch_folder.h"

#include <equistream/error.h>

#include <cstdlib>

namespace equistream {

namespace fs = std::filesystem;

ScratchFolder::ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "equistream-encode-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
        throw WorkError(name + ": no folder for trials could be made there");
    path_ = name;
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

}  // namespace equistream
