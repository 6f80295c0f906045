#pragma once
/// JSON as every program writes it. Names of files may hold bytes that are no UTF-8, which JSON cannot: U+FFFD stands
/// for these.
#include <nlohmann/json.hpp>

#include <string>

namespace equistream {

/// `indent` spaces a level; -1: on one line.
template <typename Json>
std::string json_text(const Json& json, int indent = -1) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// Whether JSON holds all of it.
inline bool is_utf8(const std::string& text) {
    try {
        nlohmann::json(text).dump();
        return true;
    } catch (const nlohmann::json::type_error&) {
        return false;
    }
}

/// `text` as a JSON file gives it back: U+FFFD for bytes that are not UTF-8. Its end is left out beyond
/// `longest_bytes`.
inline std::string as_json_holds(const std::string& text, std::size_t longest_bytes = std::string::npos) {
    std::string held = nlohmann::json::parse(json_text(nlohmann::json(text))).get<std::string>();
    while (held.size() > longest_bytes || !is_utf8(held))
        held.pop_back();
    return held;
}

}  // namespace equistream
