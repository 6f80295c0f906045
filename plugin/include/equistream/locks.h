#pragma once
/// Keeps two writers from the same file or folder. The locks are the kernel's (flock): they end with their process,
/// however it ends, and leave no files. A file system without locks locks nothing, silently.
#include <filesystem>
#include <string>

namespace equistream {

/// What open_locked_file does with a missing file: create it, or fail with ENOENT.
enum class IfMissing { make, fail };

/// Opens `file` for writing without truncating it, and locks it until the caller closes the descriptor that is
/// returned. Does not wait, and does not follow a symbolic link. -1 with errno set on failure; EWOULDBLOCK: another
/// writer has it; EINVAL, ENXIO or EISDIR: not a regular file.
int open_locked_file(const std::filesystem::path& file, IfMissing if_missing = IfMissing::make);

/// Whether the open file is the one of this name: another process may have renamed or replaced it meanwhile.
bool is_still_named(int descriptor, const std::filesystem::path& name);

/// Words for a message: why open_locked_file failed with this errno.
std::string lock_problem(const std::filesystem::path& file, int error_number);

/// Locks an existing folder while the object lives. The constructor throws InputError if another object holds the lock,
/// in this process or any other. A folder that cannot be opened is not locked, without an error.
class FolderLock {
public:
    explicit FolderLock(const std::filesystem::path& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    int descriptor_ = -1;
};

/// Creates the folder if it is missing. Throws InputError naming it unless files can be created in it.
void require_writable_folder(const std::filesystem::path& folder);

}  // namespace equistream
