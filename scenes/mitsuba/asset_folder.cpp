#include "asset_folder.h"

#include <equistream/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace equistream::mitsuba_xml {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t buffer_bytes = 1 << 20;

[[noreturn]] void fail(const fs::path& file, const std::string& reason) {
    throw WorkError(file.string() + ": cannot be written: " + reason);
}

fs::path folder_for(const fs::path& scene_file) {
    // "$" would start a parameter in Mitsuba's XML.
    std::string name = scene_file.stem().string() + ".files";
    std::replace(name.begin(), name.end(), '$', '_');
    return scene_file.parent_path() / name;
}

/// Whether a conversion writes files with this extension: nothing else may be deleted with the folder.
bool is_ours(const fs::path& file) {
    static constexpr const char* extensions[] = {".ply", ".png", ".jpg", ".exr"};
    return std::find(std::begin(extensions), std::end(extensions), file.extension()) != std::end(extensions);
}

void require_ours(const fs::path& folder) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (!entry.is_regular_file() || !is_ours(entry.path()))
            throw InputError(expected_found(folder.string(), "a folder that an earlier conversion wrote",
                                            entry.path().filename().string() + " in it"));
}

}  // namespace

AssetFile::AssetFile(fs::path file) : file_(std::move(file)) {
    descriptor_ = open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
        fail(file_, std::strerror(errno));
    buffer_.reserve(buffer_bytes);
}

AssetFile::~AssetFile() {
    if (descriptor_ >= 0)
        ::close(descriptor_);
}

void AssetFile::write(const void* data, std::size_t bytes) {
    if (buffer_.size() + bytes > buffer_bytes)
        flush();
    const auto* from = static_cast<const std::uint8_t*>(data);
    buffer_.insert(buffer_.end(), from, from + bytes);
}

void AssetFile::flush() {
    const std::uint8_t* next = buffer_.data();
    std::size_t left = buffer_.size();
    while (left > 0) {
        const ssize_t written = ::write(descriptor_, next, left);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            fail(file_, std::strerror(written < 0 ? errno : ENOSPC));
        next += written;
        left -= static_cast<std::size_t>(written);
    }
    bytes_ += buffer_.size();
    buffer_.clear();
}

std::uint64_t AssetFile::close() {
    flush();
    const int descriptor = std::exchange(descriptor_, -1);
    if (::close(descriptor) != 0)
        fail(file_, std::strerror(errno));
    return bytes_;
}

AssetFolder::AssetFolder(const fs::path& scene_file, bool overwrite) : folder_(folder_for(scene_file)) {
    const fs::path parent = folder_.has_parent_path() ? folder_.parent_path() : fs::path(".");
    std::error_code error;
    if (!fs::is_directory(parent, error))
        throw InputError(expected_found(scene_file.string(), "a folder to write to", "none at " + parent.string()));
    for (const fs::path& there : {scene_file, folder_})
        if (!overwrite && fs::exists(fs::symlink_status(there, error)))
            throw InputError(expected_found(there.string(), "nothing there, or --overwrite", "one"));
    if (fs::exists(folder_, error))
        require_ours(folder_);
    aside_ = parent / ("." + folder_.filename().string() + ".aside");
    fs::create_directory(aside_, error);
    if (error)
        fail(aside_, error.message());
    if (!fs::is_directory(fs::symlink_status(aside_)))
        throw InputError(expected_found(aside_.string(), "a folder of an earlier conversion", "a symbolic link"));
    lock_.emplace(aside_);
    earlier_ = parent / ("." + folder_.filename().string() + ".earlier.aside");
    // Of a run that was killed between two names.
    if (fs::exists(earlier_, error) && !fs::exists(folder_, error))
        fs::rename(earlier_, folder_, error);
    fs::remove_all(earlier_, error);
    for (const fs::directory_entry& left_behind : fs::directory_iterator(aside_))
        fs::remove_all(left_behind.path(), error);
}

AssetFolder::~AssetFolder() {
    std::error_code error;
    if (kept_ || !lock_)
        return;
    fs::remove_all(placed_ ? folder_ : aside_, error);
    if (placed_ && fs::exists(earlier_, error))
        fs::rename(earlier_, folder_, error);
}

std::string AssetFolder::reference_to(const std::string& name) const {
    return folder_.filename().string() + "/" + name;
}

void AssetFolder::write_file(const std::string& name, std::span<const std::uint8_t> bytes) {
    AssetFile file(path_of(name));
    file.write(bytes.data(), bytes.size());
    count(file.close());
}

void AssetFolder::place() {
    std::error_code error;
    if (fs::exists(folder_, error))
        fs::rename(folder_, earlier_, error);
    if (!error)
        fs::rename(aside_, folder_, error);
    if (error)
        fail(folder_, error.message());
    placed_ = true;
}

void AssetFolder::keep() {
    std::error_code error;
    fs::remove_all(earlier_, error);
    kept_ = true;
}

}  // namespace equistream::mitsuba_xml
