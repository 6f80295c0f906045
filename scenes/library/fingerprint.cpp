#include "fingerprint.h"

#include <nlohmann/json.hpp>

#include <charconv>
#include <fstream>
#include <string>

namespace equistream {

namespace fs = std::filesystem;

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

void add_named_files(const nlohmann::json& list, const fs::path& folder, ContentHash& hash) {
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
        if (fs::is_regular_file(file, error))
            hash.add_file(file, "file of the model");
    }
}

}  // namespace

void add_model_to_hash(const fs::path& model, ContentHash& hash) {
    hash.add_file(model, "model");
    if (model.extension() != ".gltf")
        return;
    std::ifstream stream(model);
    const nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
    if (!json.is_object())
        return;
    for (const char* key : {"buffers", "images"})
        if (json.contains(key))
            add_named_files(json[key], model.parent_path(), hash);
}

}  // namespace equistream
