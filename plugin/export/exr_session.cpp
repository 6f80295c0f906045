#include "exr_session.h"

#include <equistream/error.h>
#include <equistream/image.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace equistream {
namespace {

std::string one_line(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 32 || c > 126; }, ' ');
    return text;
}

}  // namespace

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
    descriptor_ = open(file_.c_str(), O_RDONLY | O_CLOEXEC);
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

}  // namespace equistream
