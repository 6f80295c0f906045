#include <equistream/error.h>
#include <equistream_cli/scratch_folder.h>

#include <cstdlib>

namespace equistream::cli {

namespace fs = std::filesystem;

ScratchFolder::ScratchFolder(const std::string& program) {
    std::error_code problem;
    const fs::path parent = fs::temp_directory_path(problem);
    if (problem)
        throw WorkError("the folder for temporary files (TMPDIR): " + problem.message());
    std::string name = (parent / ("equistream-" + program + "-XXXXXX")).string();
    if (mkdtemp(name.data()) == nullptr)
        throw WorkError(name + ": no folder could be made there");
    path_ = name;
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

}  // namespace equistream::cli
