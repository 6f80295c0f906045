#pragma once
/// Keeps two processes from writing to the same place at once. The locks are the kernel's (flock): they end with their
/// process, however it ends, and leave nothing behind. On a file system that has none nothing is locked.
#include <filesystem>
#include <string>

namespace equistream {

enum class IfMissing { make, fail };

/// Opens `file` for writing, as it is, and locks it until the descriptor is closed. No symbolic link is followed. -1
/// with errno set where it cannot be opened; EWOULDBLOCK: another process is writing it.
int open_locked_file(const std::filesystem::path& file, IfMissing if_missing = IfMissing::make);

/// What open_locked_file found, of its errno, for a message.
std::string lock_problem(const std::filesystem::path& file, int error_number);

/// Holds an existing folder for one process at a time; throws InputError if another one holds it.
class FolderLock {
public:
    explicit FolderLock(const std::filesystem::path& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    int descriptor_ = -1;
};

/// Makes sure that files can be made in a folder, creating it if need be; throws InputError naming it.
void require_writable_folder(const std::filesystem::path& folder);

}  // namespace equistream
