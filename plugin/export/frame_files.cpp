#include <equistream/error.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace equistream {
namespace {

constexpr std::string_view prefix = "frame.";

/// The index in "frame.NNNN.EXT", if the name is exactly what frame_file_name would write.
std::optional<std::int64_t> frame_index(const std::string& name, const std::string& extension) {
    if (!name.starts_with(prefix) || !name.ends_with("." + extension))
        return std::nullopt;
    std::int64_t index = -1;
    std::from_chars(name.data() + prefix.size(), name.data() + name.size(), index);
    if (index < 0 || frame_file_name(index, extension) != name)
        return std::nullopt;
    return index;
}

}  // namespace

std::string frame_file_name(std::int64_t index, const std::string& extension) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%04lld", static_cast<long long>(index));
    return std::string(prefix) + digits + "." + extension;
}

std::vector<std::int64_t> list_frames(const std::filesystem::path& folder, const std::string& extension) {
    std::error_code error;
    std::filesystem::directory_iterator entries(folder, error);
    if (error)
        throw InputError(expected_found(folder.string(), "a folder of frames", error.message()));
    std::vector<std::int64_t> indices;
    for (const auto& entry : entries)
        if (const auto index = frame_index(entry.path().filename().string(), extension))
            indices.push_back(*index);
    std::sort(indices.begin(), indices.end());
    return indices;
}

}  // namespace equistream
