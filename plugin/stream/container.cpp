#include "container.h"

#include <equistream/error.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

namespace equistream {

namespace {

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
    std::string path = target.substr(0, av::is_url(target) ? target.find('?') : std::string::npos);
    if (av::is_url(target)) {
        const auto authority = path.find("://");
        const auto slash = path.find('/', authority == std::string::npos ? 0 : authority + 3);
        path = slash == std::string::npos ? "" : path.substr(slash);
    }
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

}  // namespace

Container choose_container(const std::string& target) {
    const std::string extension = extension_of(target);
    const auto named = [&](std::string_view wanted) {
        return std::find_if(std::begin(rows), std::end(rows), [&](const Row& row) { return row.extension == wanted; });
    };
    if (const auto row = named(extension); row != std::end(rows))
        return row->container;
    if (av::is_url(target))
        return named(".ts")->container;
    std::string accepted;
    for (const Row& row : rows)
        accepted += (accepted.empty() ? "" : ", ") + std::string(row.extension);
    throw InputError(
        expected_found(target, "a name ending in one of " + accepted, extension.empty() ? "no extension" : extension));
}

void set_muxer_options(const Container& container, av::Options& options) {
    const std::string_view muxer = container.muxer;
    if (muxer == "mp4")  // a fragment per group of pictures; each can be read without what follows
        options.set("movflags", "frag_keyframe+empty_moov+default_base_moof");
}

}  // namespace equistream
