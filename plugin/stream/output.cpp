#include "output.h"

#include <equistream/error.h>
#include <equistream/locks.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>

namespace equistream {

namespace {

constexpr std::size_t min_buffer_bytes = 1 << 16;

bool exists_and_is_no_file(const std::string& path) {
    struct stat status;
    return stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
}

struct Row {
    std::string_view extension;
    Container container;
};

const Row rows[] = {
    {".mp4", {"mp4", false, true, true, {}}},
    {".mkv", {"matroska", false, true, true, {}}},
    {".ts", {"mpegts", false, false, false, {}}},
    {".nut", {"nut", false, false, false, {}}},
    {".h264", {"h264", true, false, false, Codec::h264}},
    {".h265", {"hevc", true, false, false, Codec::h265}},
};

std::string extension_of(const std::string& target) {
    std::string path = target.substr(0, is_url(target) ? target.find('?') : std::string::npos);
    if (is_url(target)) {
        const auto authority = path.find("://");
        const auto slash = path.find('/', authority == std::string::npos ? 0 : authority + 3);
        path = slash == std::string::npos ? "" : path.substr(slash);
    }
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

/// Where a link leads, its file is replaced and not the link. The file need not be there yet.
std::string behind_links(const std::string& target) {
    namespace fs = std::filesystem;
    constexpr int max_links = 40;  // as the system follows
    fs::path file = target;
    std::error_code error;
    for (int links = 0; fs::is_symlink(file, error); ++links) {
        const fs::path leads_to = links < max_links ? fs::read_symlink(file, error) : fs::path();
        if (leads_to.empty())
            throw InputError(expected_found(target, "a place that can be written",
                                            error ? error.message() : "a symbolic link that leads back to itself"));
        file = file.parent_path() / leads_to;
    }
    return file.string();
}

}  // namespace

int Output::write_bytes(void* self, std::uint8_t* bytes, int size) {
    auto& output = *static_cast<Output*>(self);
    if (output.file_ >= 0) {
        output.write_to_file(bytes, size);
        if (output.first_errno_ != 0)
            return AVERROR(output.first_errno_);
    }
    try {  // nothing may be thrown through libav
        if (output.tap_)
            output.tap_->take({bytes, std::size_t(size)});
    } catch (const std::exception&) {
        output.first_errno_ = ENOMEM;
        return AVERROR(ENOMEM);
    }
    return size;
}

std::int64_t Output::go_to(void* self, std::int64_t offset, int whence) {
    const int file = static_cast<Output*>(self)->file_;
    struct stat status;
    if (whence == AVSEEK_SIZE)
        return fstat(file, &status) == 0 ? std::int64_t(status.st_size) : AVERROR(errno);
    const off_t position = lseek(file, offset, whence & ~AVSEEK_FORCE);
    return position < 0 ? AVERROR(errno) : position;
}

void Output::write_to_file(const std::uint8_t* bytes, int size) {
    for (int done = 0; done < size;) {
        const auto written = write(file_, bytes + done, static_cast<std::size_t>(size - done));
        if (written < 0 && errno == EINTR)
            continue;
        if (written < 0) {
            if (first_errno_ == 0)
                first_errno_ = errno;
            return;
        }
        done += static_cast<int>(written);
        has_bytes_ = true;
    }
}

/// What an earlier run left there is overwritten, once it is certain that nobody is writing it now.
void Output::open_aside() {
    target_ = behind_links(target_);
    aside_ = target_ + ".part";
    file_ = open_locked_file(aside_);
    if (file_ < 0 && errno == EWOULDBLOCK)
        throw InputError(expected_found(target_, "a file that no other process is writing",
                                        aside_ + ", which another process is writing"));
    if (file_ >= 0 && ftruncate(file_, 0) != 0)
        close(std::exchange(file_, -1));
}

void Output::make_io(std::size_t max_header_bytes) {
    const auto buffer_bytes = static_cast<int>(std::max(max_header_bytes, min_buffer_bytes));
    auto* buffer = static_cast<unsigned char*>(av_malloc(buffer_bytes));
    const bool can_go_back = !aside_.empty() && !tap_;
    io_ = buffer ? avio_alloc_context(buffer, buffer_bytes, 1, this, nullptr, &Output::write_bytes,
                                      can_go_back ? &Output::go_to : nullptr)
                 : nullptr;
    if (!io_) {
        av_free(buffer);
        if (file_ >= 0)
            close(file_);
        throw std::bad_alloc();
    }
}

Output::Output(const std::string& target, std::optional<StreamTap> tap, std::size_t max_header_bytes)
    : target_(target), tap_(std::move(tap)) {
    if (tap_ && tap_->alone) {
        make_io(max_header_bytes);
        return;
    }
    if (tap_ && is_url(target))
        throw InputError(expected_found(target, "a file: an address cannot be tapped", "an address"));
    if (is_url(target)) {
        const int code = avio_open2(&io_, target.c_str(), AVIO_FLAG_WRITE, nullptr, nullptr);
        if (code < 0)
            throw InputError(expected_found(target, "an address that can be written", av::error_text(code)));
        io_->seekable = 0;
        return;
    }
    if (exists_and_is_no_file(target))
        file_ = open(target.c_str(), O_WRONLY | O_CLOEXEC);
    else
        open_aside();
    if (file_ < 0)
        throw InputError(expected_found(target_, "a place that can be written",
                                        aside_.empty() ? std::strerror(errno) : lock_problem(aside_, errno)));
    make_io(max_header_bytes);
}

Output::~Output() {
    if (file_ < 0 && !tap_) {
        avio_closep(&io_);
        return;
    }
    avio_flush(io_);
    av_freep(&io_->buffer);
    avio_context_free(&io_);
    if (file_ < 0)
        return;
    if (!has_bytes_ && !aside_.empty())
        unlink(aside_.c_str());
    close(file_);
}

std::string Output::write_error() const {
    if (first_errno_ != 0)
        return std::strerror(first_errno_);
    return io_->error < 0 ? av::error_text(io_->error) : "";
}

void Output::fail() const {
    const std::string kept = aside_.empty() || !has_bytes_ ? "" : "; what was coded so far is kept in " + aside_;
    throw WorkError(target_ + ": cannot be written: " + write_error() + kept);
}

void Output::flush() {
    avio_flush(io_);
    if (file_ >= 0 && first_errno_ == 0 && fsync(file_) != 0 && errno != EINVAL && errno != EROFS)
        first_errno_ = errno;
    if (!write_error().empty())
        fail();
}

void Output::finish() {
    flush();
    if (!aside_.empty() && std::rename(aside_.c_str(), target_.c_str()) != 0) {
        first_errno_ = errno;
        fail();
    }
}

Container choose_container(const std::string& target) {
    const std::string extension = extension_of(target);
    const auto named = [&](std::string_view wanted) {
        return std::find_if(std::begin(rows), std::end(rows), [&](const Row& row) { return row.extension == wanted; });
    };
    if (const auto row = named(extension); row != std::end(rows))
        return row->container;
    if (is_url(target))
        return named(".ts")->container;
    std::string accepted;
    for (const Row& row : rows)
        accepted += (accepted.empty() ? "" : ", ") + std::string(row.extension);
    throw InputError(
        expected_found(target, "a name ending in one of " + accepted, extension.empty() ? "no extension" : extension));
}

}  // namespace equistream
