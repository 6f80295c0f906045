#pragma once
/// Other programs of ours, which lie beside this one, and files that only this process needs.
#include <filesystem>
#include <string>

namespace equistream::cli {

/// Thrown where another program of ours, run as a child, has failed and said why: run_program says nothing more.
struct ChildFailed {
    int exit_code;
};

/// Of the running program: the others lie beside it.
std::filesystem::path own_folder();

// Where files lie that only this process needs. The folder and all in it go with the object, or where SIGINT, SIGTERM
// or SIGHUP ends the process. A program that handles these signals itself does so before it makes the first folder.

class ScratchFolder {
public:
    /// A new one among the system's temporary files (TMPDIR), named after the program. Throws WorkError where none can
    /// be made.
    explicit ScratchFolder(const std::string& program);
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    std::string file(const std::string& name) const { return (path_ / name).string(); }
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

}  // namespace equistream::cli
