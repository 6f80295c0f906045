#pragma once
/// Where a trial's stream lies while it is looked at. The folder and all in it go with the object.
#include <filesystem>
#include <string>

namespace equistream {

class ScratchFolder {
public:
    /// Throws WorkError where none can be made.
    ScratchFolder();
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    std::string file() const { return (path_ / "trial.nut").string(); }

private:
    std::filesystem::path path_;
};

}  // namespace equistream
