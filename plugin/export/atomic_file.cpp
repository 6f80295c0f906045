#include "atomic_file.h"

#include <equistream/error.h>
#include <equistream/locks.h>
#include <equistream/sequence.h>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace equistream {
namespace {

constexpr const char* aside_extension = ".aside";

std::filesystem::path folder_of(const std::filesystem::path& file) {
    return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

}  // namespace

void AtomicFile::fail(const char* what, int error_number) const {
    throw WorkError(file_.string() + ": " + what + ": " + std::strerror(error_number));
}

AtomicFile::AtomicFile(std::filesystem::path file) : file_(std::move(file)) {
    aside_ = folder_of(file_) / ("." + file_.filename().string() + aside_extension);
    descriptor_ = open_locked_file(aside_);
    if (descriptor_ < 0 && errno == EWOULDBLOCK)
        throw WorkError(file_.string() + ": is being written by another process");
    if (descriptor_ < 0)
        throw WorkError(file_.string() + ": cannot be written: " + lock_problem(aside_, errno));
    if (ftruncate(descriptor_, 0) != 0) {
        const int error_number = errno;
        close(descriptor_);
        fail("cannot be written", error_number);
    }
}

AtomicFile::~AtomicFile() {
    if (descriptor_ < 0)
        return;
    unlink(aside_.c_str());
    close(descriptor_);
}

void AtomicFile::write_at(const void* data, std::size_t bytes, std::uint64_t offset) {
    const char* next = static_cast<const char*>(data);
    while (bytes > 0) {
        const ssize_t written = pwrite(descriptor_, next, bytes, static_cast<off_t>(offset));
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            fail("cannot be written", written < 0 ? errno : ENOSPC);
        next += written;
        bytes -= static_cast<std::size_t>(written);
        offset += static_cast<std::uint64_t>(written);
    }
}

void AtomicFile::commit() {
    if (fsync(descriptor_) != 0)
        fail("cannot be written", errno);
    if (rename(aside_.c_str(), file_.c_str()) != 0)
        fail("cannot be put in place", errno);
    close(std::exchange(descriptor_, -1));
    const int folder = open(folder_of(file_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
        // Some file systems cannot sync a folder; the file itself is safe by now.
        fsync(folder);
        close(folder);
    }
}

void remove_unfinished_files(const std::filesystem::path& folder) {
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(".") || !name.ends_with(aside_extension))
            continue;
        const int descriptor = open_locked_file(entry.path(), IfMissing::fail);
        if (descriptor < 0)
            continue;
        unlink(entry.path().c_str());
        close(descriptor);
    }
}

void write_file_atomically(const std::filesystem::path& file, const std::string& text) {
    AtomicFile aside(file);
    aside.write_at(text.data(), text.size(), 0);
    aside.commit();
}

}  // namespace equistream
