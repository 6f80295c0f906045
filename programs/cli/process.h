#pragma once
/// Other programs of ours, which lie beside this one, files that only this process needs, and how a signal ends it.
#include "own_folder.h"

#include <atomic>
#include <filesystem>
#include <string>

namespace equistream::cli {

/// Thrown where another program of ours, run as a child, has failed and said why: run_program says nothing more.
struct ChildFailed {
    int exit_code;
};

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

// What SIGINT and SIGTERM do. Whoever has a program ignore them when it starts is obeyed.

/// They end the process at once, after this line on standard error. `unfinished`, a file, is removed if it is still
/// empty then.
void say_at_interrupt(const std::string& line, const std::filesystem::path& unfinished = {});
/// From here on the first of each kind is only noted, for a program to end in order; the second ends it at once. No
/// folder is removed by them any more.
void note_interrupts();
/// Whether one was noted.
const std::atomic<bool>& interrupted();
/// Ends the process by a SIGINT that was noted: shells end their loops for programs that end so.
void end_by_noted_interrupt();

}  // namespace equistream::cli
