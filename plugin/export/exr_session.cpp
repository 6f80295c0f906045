#include "exr_session.h"

#include <equistream/error.h>
#include <equistream/image.h>
#include <equistream/locks.h>
#include <equistream/sequence.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace equistream {
namespace {

constexpr const char* aside_extension = ".aside";

std::filesystem::path folder_of(const std::filesystem::path& file) {
    return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

std::string one_line(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 32 || c > 126; }, ' ');
    return text;
}

/// EXR's predictor: even bytes first, then odd ones, then each byte's difference from the one before it (+128).
void predict(std::span<const std::uint8_t> in, std::vector<std::uint8_t>& out) {
    out.resize(in.size());
    const std::size_t half = (in.size() + 1) / 2;
    for (std::size_t i = 0; i < in.size() / 2; ++i) {
        out[i] = in[2 * i];
        out[half + i] = in[2 * i + 1];
    }
    if (in.size() % 2 != 0)
        out[half - 1] = in[in.size() - 1];
    std::uint8_t previous = out.empty() ? std::uint8_t{0} : out[0];
    for (std::size_t i = 1; i < out.size(); ++i) {
        const std::uint8_t current = out[i];
        out[i] = static_cast<std::uint8_t>(current - previous + 128);
        previous = current;
    }
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

void AtomicFile::commit(const std::function<void()>& before_it_appears) {
    if (fsync(descriptor_) != 0)
        fail("cannot be written", errno);
    if (before_it_appears)
        before_it_appears();
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

std::int64_t ExrSession::read_callback(exr_const_context_t, void* self, void* buffer, std::uint64_t bytes,
                                       std::uint64_t offset, exr_stream_error_func_ptr_t) {
    const auto& session = *static_cast<ExrSession*>(self);
    std::uint64_t done = 0;
    while (done < bytes) {
        const ssize_t got = pread(session.descriptor_, static_cast<char*>(buffer) + done, bytes - done,
                                  static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            break;
        done += static_cast<std::uint64_t>(got);
    }
    return static_cast<std::int64_t>(done);
}

std::int64_t ExrSession::size_callback(exr_const_context_t, void* self) {
    return static_cast<ExrSession*>(self)->size_bytes_;
}

std::int64_t ExrSession::write_callback(exr_const_context_t, void* self, const void* buffer, std::uint64_t bytes,
                                        std::uint64_t offset, exr_stream_error_func_ptr_t) {
    auto& session = *static_cast<ExrSession*>(self);
    try {
        session.target_->write_at(buffer, bytes, offset);
        return static_cast<std::int64_t>(bytes);
    } catch (const std::exception& error) {
        const std::lock_guard lock(session.error_mutex_);
        if (session.first_error_.empty())
            session.first_error_ = error.what();
        return -1;
    }
}

void ExrSession::error_callback(exr_const_context_t context, exr_result_t, const char* message) {
    void* self = nullptr;
    if (exr_get_user_data(context, &self) != EXR_ERR_SUCCESS || self == nullptr)
        return;
    const auto& session = *static_cast<ExrSession*>(self);
    const std::lock_guard lock(session.error_mutex_);
    if (session.first_error_.empty())
        session.first_error_ = message;
}

void ExrSession::open_descriptor() {
    // A pipe that nobody writes must not be waited for.
    descriptor_ = open(file_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor_ < 0)
        throw InputError(expected_found(file_.string(), "an EXR frame", std::strerror(errno)));
    struct stat status {};
    if (fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
        close(descriptor_);
        throw InputError(expected_found(file_.string(), "an EXR frame", "not a regular file"));
    }
    size_bytes_ = status.st_size;
}

ExrSession::ExrSession(const std::filesystem::path& file, AtomicFile* target) : file_(file), target_(target) {
    exr_context_initializer_t settings{};
    settings.size = sizeof settings;
    settings.zip_level = -2;
    settings.dwa_quality = -1;
    settings.user_data = this;
    settings.error_handler_fn = error_callback;
    settings.max_image_width = max_image_side;
    settings.max_image_height = max_image_side;
    exr_result_t result = EXR_ERR_SUCCESS;
    if (target_ != nullptr) {
        settings.write_fn = write_callback;
        result = exr_start_write(&context_, file_.c_str(), EXR_WRITE_FILE_DIRECTLY, &settings);
    } else {
        open_descriptor();
        settings.read_fn = read_callback;
        settings.size_fn = size_callback;
        settings.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
        result = exr_start_read(&context_, file_.c_str(), &settings);
    }
    if (result != EXR_ERR_SUCCESS && descriptor_ >= 0)
        close(descriptor_);
    check(result, "opening");
}

ExrSession::~ExrSession() {
    exr_finish(&context_);
    if (descriptor_ >= 0)
        close(descriptor_);
}

void ExrSession::check(exr_result_t result, const char* doing) const {
    if (result == EXR_ERR_SUCCESS)
        return;
    std::string reason = exr_get_default_error_message(result);
    {
        const std::lock_guard lock(error_mutex_);
        if (!first_error_.empty())
            reason = first_error_;
    }
    if (target_ == nullptr)
        throw InputError(expected_found(file_.string(), "a whole EXR frame", one_line(reason) + " (" + doing + ")"));
    if (reason.starts_with(file_.string()))
        throw WorkError(reason);
    throw WorkError(file_.string() + ": " + doing + ": " + one_line(reason));
}

void ExrSession::forget_errors() const {
    const std::lock_guard lock(error_mutex_);
    first_error_.clear();
}

void ExrSession::refuse(const std::string& expected, const std::string& found) const {
    throw InputError(expected_found(file_.string(), expected, found));
}

ZipCompressor::ZipCompressor() : compressor_(libdeflate_alloc_compressor(1), libdeflate_free_compressor) {
    if (!compressor_)
        throw std::bad_alloc();
}

void ZipCompressor::compress(std::span<const std::uint8_t> packed, std::vector<std::uint8_t>& out) {
    predict(packed, predicted_);
    out.resize(packed.size());
    const std::size_t size =
        libdeflate_zlib_compress(compressor_.get(), predicted_.data(), packed.size(), out.data(), out.size());
    if (size > 0 && size < packed.size())
        out.resize(size);
    else
        out.assign(packed.begin(), packed.end());
}

}  // namespace equistream
