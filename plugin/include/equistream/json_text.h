#pragma once
/// Writing JSON. Bytes that are not UTF-8, which file names may hold, become U+FFFD.
#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>

namespace equistream {

/// `json` as text, with `indent` spaces for each level; -1: on one line.
std::string json_text(const nlohmann::json& json, int indent = -1);
std::string json_text(const nlohmann::ordered_json& json, int indent = -1);

/// Whether the text is UTF-8 throughout, so that JSON holds it unchanged.
bool is_utf8(const std::string& text);

/// `text` after writing it to JSON and reading it back: U+FFFD for bytes that are not UTF-8. It is cut to at most
/// `longest_bytes`, between characters.
std::string as_json_holds(const std::string& text, std::size_t longest_bytes = std::string::npos);

}  // namespace equistream
