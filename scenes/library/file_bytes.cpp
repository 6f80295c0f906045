#include "file_bytes.h"

#include "obj_files.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <nlohmann/json.hpp>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <set>

namespace equistream {

namespace fs = std::filesystem;

std::ifstream open_regular_file(const fs::path& file, const std::string& what) {
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (!fs::exists(status))
        throw InputError(expected_found(file.string(), "a " + what, "no such file"));
    if (!fs::is_regular_file(status))
        throw InputError(expected_found(file.string(), "a " + what, "something that is not a regular file"));
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw InputError(expected_found(file.string(), "a readable " + what, "a file that cannot be opened"));
    return stream;
}

std::vector<std::uint8_t> read_file_bytes(const fs::path& file, const std::string& what, std::uint64_t limit_bytes) {
    std::ifstream stream = open_regular_file(file, what);
    std::error_code error;
    const std::uint64_t size = fs::file_size(file, error);
    if (error)
        throw InputError(expected_found(file.string(), "a readable " + what, error.message()));
    if (size > limit_bytes)
        throw InputError(expected_found(file.string(),
                                        "a " + what + " of at most " + std::to_string(limit_bytes) + " bytes",
                                        std::to_string(size) + " bytes"));
    std::vector<std::uint8_t> bytes(size);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (static_cast<std::uint64_t>(stream.gcount()) != size)
        throw InputError(expected_found(file.string(), std::to_string(size) + " bytes of " + what,
                                        std::to_string(stream.gcount()) + " bytes that could be read"));
    return bytes;
}

void require_at_most_4_gib(std::uint64_t bytes, const std::string& where, const std::string& what) {
    if (bytes > std::uint64_t{1} << 32)
        throw InputError(expected_found(where, what + " of at most 4 GiB in all",
                                        formatted("%.2f GiB", std::ldexp(static_cast<double>(bytes), -30))));
}

void ContentHash::add(std::span<const std::uint8_t> bytes) {
    state_ = XXH64(bytes.data(), bytes.size(), state_);
}

void ContentHash::add(const std::string& text) {
    add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

void ContentHash::add_file(const fs::path& file, const std::string& what) {
    std::ifstream stream = open_regular_file(file, what);
    std::vector<std::uint8_t> block(std::size_t{1} << 20);
    while (stream) {
        stream.read(reinterpret_cast<char*>(block.data()), static_cast<std::streamsize>(block.size()));
        add({block.data(), static_cast<std::size_t>(stream.gcount())});
    }
    if (stream.bad())
        throw InputError(expected_found(file.string(), "a readable " + what, "a read error"));
}

std::string ContentHash::hex() const {
    char text[17];
    std::snprintf(text, sizeof text, "%016" PRIx64, state_);
    return text;
}

namespace {

std::string percent_decoded(const std::string& uri) {
    std::string text;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        unsigned code = 0;
        const char* digits = uri.data() + i + 1;
        if (uri[i] == '%' && i + 2 < uri.size() && std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2) {
            text += static_cast<char>(code);
            i += 2;
        } else {
            text += uri[i];
        }
    }
    return text;
}

/// load_model refuses anything larger.
constexpr std::uintmax_t model_size_limit = 0xffffffff;

/// The JSON of a .gltf or .glb; empty where there is none.
std::string json_text(const fs::path& model) {
    std::error_code error;
    const std::uintmax_t file_bytes = fs::file_size(model, error);
    std::ifstream stream(model, std::ios::binary);
    std::array<std::uint32_t, 5> header{};  // "glTF", version, length; length of the JSON, "JSON"
    stream.read(reinterpret_cast<char*>(header.data()), sizeof header);
    const bool is_glb = stream && std::memcmp(header.data(), "glTF", 4) == 0;
    const std::uintmax_t begin = is_glb ? sizeof header : 0;
    if (error || begin > file_bytes || file_bytes > model_size_limit)
        return {};
    std::string text(std::min<std::uintmax_t>(is_glb ? header[3] : file_bytes, file_bytes - begin), '\0');
    stream.clear();
    stream.seekg(static_cast<std::streamoff>(begin));
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    return text;
}

/// Each file once, however often it is named: a small model could name a large one without end.
void add_named_files(const nlohmann::json& list, const fs::path& folder, std::set<fs::path>& named, ContentHash& hash) {
    if (!list.is_array())
        return;
    std::error_code error;
    for (const nlohmann::json& entry : list) {
        const std::string uri =
            entry.is_object()
                ? entry.value("uri", nlohmann::json()).is_string() ? entry["uri"].get<std::string>() : std::string()
                : std::string();
        if (uri.empty() || uri.starts_with("data:"))
            continue;
        const fs::path file = folder / percent_decoded(uri);
        if (fs::is_regular_file(file, error) && named.insert(file.lexically_normal()).second)
            hash.add_file(file, "file of the model");
    }
}

void add_model(const fs::path& model, ContentHash& hash) {
    hash.add_file(model, "model");
    if (is_obj(model)) {
        for (const fs::path& file : files_of_obj(model))
            hash.add_file(file, "file of the model");
        return;
    }
    const std::string text = json_text(model);
    if (text.find("\"uri\"") == std::string::npos)  // the rule: everything in one file, which may be large
        return;
    const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object())
        return;
    std::set<fs::path> named;
    for (const char* key : {"buffers", "images"})
        if (json.contains(key))
            add_named_files(json[key], model.parent_path(), named, hash);
}

}  // namespace

std::string content_fingerprint(const std::vector<fs::path>& files, const std::string& text) {
    ContentHash hash;
    for (const fs::path& file : files)
        hash.add_file(file, "file of the scene");
    hash.add(text);
    return hash.hex();
}

std::string geometry_fingerprint(const fs::path& model, double model_unit_m, const std::vector<MovingObject>& moving) {
    ContentHash hash;
    add_model(model, hash);
    if (model_unit_m != 1)
        hash.add(formatted("%.17g", model_unit_m));
    for (const MovingObject& object : moving) {
        hash.add(object.object);
        hash.add(path_fingerprint(object.path));
    }
    return hash.hex();
}

}  // namespace equistream
