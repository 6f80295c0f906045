#include <equistream/json_text.h>

#include <nlohmann/json.hpp>

namespace equistream {

std::string json_text(const nlohmann::json& json, int indent) {
    return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string json_text(const nlohmann::ordered_json& json, int indent) {
    return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

bool is_utf8(const std::string& text) {
    try {
        nlohmann::json(text).dump();
        return true;
    } catch (const nlohmann::json::type_error&) {
        return false;
    }
}

std::string as_json_holds(const std::string& text, std::size_t longest_bytes) {
    std::string held = nlohmann::json::parse(json_text(nlohmann::json(text))).get<std::string>();
    while (held.size() > longest_bytes || !is_utf8(held))
        held.pop_back();
    return held;
}

}  // namespace equistream
