#include <equistream/error.h>
#include <equistream/locks.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace equistream {
namespace {

bool is_locked_elsewhere(int descriptor) {
    return flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

/// Between opening and locking, another process may have renamed the file away: then ours is not the named one.
bool still_named(int descriptor, const std::filesystem::path& name) {
    struct stat opened {};
    struct stat named {};
    return fstat(descriptor, &opened) == 0 && stat(name.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
           opened.st_dev == named.st_dev;
}

}  // namespace

int open_locked_file(const std::filesystem::path& file, IfMissing if_missing) {
    const int flags = O_WRONLY | O_CLOEXEC | (if_missing == IfMissing::make ? O_CREAT : 0);
    for (;;) {
        const int descriptor = open(file.c_str(), flags, 0666);
        if (descriptor < 0)
            return -1;
        const bool elsewhere = is_locked_elsewhere(descriptor);
        if (!elsewhere && still_named(descriptor, file))
            return descriptor;
        close(descriptor);
        if (elsewhere) {
            errno = EWOULDBLOCK;
            return -1;
        }
    }
}

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    // A folder that cannot be opened here fails where it is used, with the reason.
    if (descriptor_ < 0 || !is_locked_elsewhere(descriptor_))
        return;
    close(descriptor_);
    throw InputError(
        expected_found(folder.string(), "a folder that no other process is writing to", "one that is in use"));
}

FolderLock::~FolderLock() {
    if (descriptor_ >= 0)
        close(descriptor_);
}

}  // namespace equistream
