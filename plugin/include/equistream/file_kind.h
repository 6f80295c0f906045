#pragma once
/// Recognises a file that a user gave to the wrong command, so that a message can name the right one.
#include "error.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

namespace equistream {

/// Type of the file that a path leads to, not_found if it does not exist. Throws InputError, with `expected` in its
/// message, if the system cannot tell: a folder on the path has no permissions, or links form a circle.
inline std::filesystem::file_type type_of(const std::filesystem::path& name, const std::string& expected) {
    std::error_code error;
    const std::filesystem::file_type type = std::filesystem::status(name, error).type();
    if (type == std::filesystem::file_type::none)
        throw InputError(expected_found(name.string(), expected, error.message()));
    return type;
}

enum class FileKind { unknown, folder, video, exr, picture, model, description, mitsuba_xml, table };

/// Decides by the first 64 bytes of a regular file, and by its extension where bytes do not suffice.
inline FileKind file_kind(const std::filesystem::path& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error))
        return FileKind::folder;
    if (!std::filesystem::is_regular_file(file, error))
        return FileKind::unknown;
    std::array<char, 64> bytes{};
    std::ifstream in(file, std::ios::binary);
    in.read(bytes.data(), bytes.size());
    const std::string_view start(bytes.data(), static_cast<std::size_t>(in.gcount()));
    const std::size_t first = start.find_first_not_of(" \t\r\n\xef\xbb\xbf");
    const std::string_view text = first == start.npos ? std::string_view() : start.substr(first);
    const std::string extension = file.extension().string();
    if (start.starts_with("\x76\x2f\x31\x01"))
        return FileKind::exr;
    if (start.starts_with("\x89PNG") || start.starts_with("\xff\xd8\xff"))
        return FileKind::picture;
    if (start.starts_with("glTF") || extension == ".gltf" || extension == ".obj")
        return FileKind::model;
    if (text.starts_with('<'))
        return FileKind::mitsuba_xml;
    if (text.starts_with('{'))
        return FileKind::description;
    if (extension == ".csv")
        return FileKind::table;
    if (start.substr(std::min<std::size_t>(4, start.size())).starts_with("ftyp") ||
        start.starts_with("\x1a\x45\xdf\xa3") || start.starts_with("nut/"))
        return FileKind::video;
    return FileKind::unknown;
}

/// Words for a message after "found": the file's kind and the commands that take it. `otherwise` for an unknown kind.
inline std::string found_kind(const std::filesystem::path& file, const std::string& otherwise) {
    switch (file_kind(file)) {
    case FileKind::folder:
        return "a folder (encode, play and view take a folder of frames)";
    case FileKind::video:
        return "a video (play, view, serve and info take it)";
    case FileKind::exr:
        return "an EXR file (info explains it; encode, play and view take its folder)";
    case FileKind::picture:
        return "a picture (compare scores folders of pictures)";
    case FileKind::model:
        return "a model (scene describe writes a scene description of it; render and scene info take that)";
    case FileKind::description:
        return "a scene description or other JSON (render renders a scene, scene info explains it)";
    case FileKind::mitsuba_xml:
        return "a scene in XML (render --host mitsuba renders Mitsuba's)";
    case FileKind::table:
        return "a table (--head or --path takes a path of poses)";
    case FileKind::unknown:
        break;
    }
    return otherwise;
}

}  // namespace equistream
