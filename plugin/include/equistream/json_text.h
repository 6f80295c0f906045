#pragma once
/// JSON as every program writes it. Names of files may hold bytes that are no UTF-8, which JSON cannot: U+FFFD stands
/// for these.
#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>

namespace equistream {

/// `indent` spaces a level; -1: on one line.
std::string json_text(const nlohmann::json& json, int indent = -1);
std::string json_text(const nlohmann::ordered_json& json, int indent = -1);

/// Whether JSON holds all of it.
bool is_utf8(const std::string& text);

/// `text` as a JSON file gives it back: U+FFFD for bytes that are not UTF-8. Its end is left out beyond
/// `longest_bytes`.
std::string as_json_holds(const std::string& text, std::size_t longest_bytes = std::string::npos);

}  // namespace equistream
