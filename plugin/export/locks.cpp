#include <equistream/error.h>
#include <equistream/locks.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace equistream {
namespace {

bool is_locked_elsewhere(int descriptor) {
    return flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

}  // namespace

bool is_still_named(int descriptor, const std::filesystem::path& name) {
    struct stat opened {};
    struct stat named {};
    return fstat(descriptor, &opened) == 0 && lstat(name.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
           opened.st_dev == named.st_dev;
}

int open_locked_file(const std::filesystem::path& file, IfMissing if_missing) {
    // A pipe that nobody reads must not be waited for.
    const int flags = O_WRONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | (if_missing == IfMissing::make ? O_CREAT : 0);
    for (;;) {
        const int descriptor = open(file.c_str(), flags, 0666);
        if (descriptor < 0)
            return -1;
        struct stat status {};
        if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
            close(descriptor);
            errno = EINVAL;
            return -1;
        }
        const bool elsewhere = is_locked_elsewhere(descriptor);
        if (!elsewhere && is_still_named(descriptor, file))  // between opening and locking
            return descriptor;
        close(descriptor);
        if (elsewhere) {
            errno = EWOULDBLOCK;
            return -1;
        }
    }
}

std::string lock_problem(const std::filesystem::path& file, int error_number) {
    if (error_number == ELOOP)
        return file.string() + ", a symbolic link";
    if (error_number == EINVAL || error_number == ENXIO)
        return file.string() + ", which is not a file";
    return std::strerror(error_number);
}

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    // A folder that cannot be opened here fails where it is used, with the reason.
    if (descriptor_ < 0 || !is_locked_elsewhere(descriptor_))
        return;
    close(descriptor_);
    throw InputError(expected_found(folder.string(), "a folder that no other process is writing to",
                                    "one in use: wait for the other process, or choose another folder"));
}

FolderLock::~FolderLock() {
    if (descriptor_ >= 0)
        close(descriptor_);
}

namespace fs = std::filesystem;

void require_writable_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    std::string why = error ? error.message() : "";
    if (!error && access(folder.c_str(), W_OK | X_OK) != 0)
        why = std::strerror(errno);
    if (!error && !fs::is_directory(folder))
        why = "not a folder";
    if (!why.empty())
        throw InputError(expected_found(folder.string(), "a folder that can be written to", why));
}

}  // namespace equistream
