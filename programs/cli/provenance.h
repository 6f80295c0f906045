#pragma once
#include <nlohmann/json.hpp>

#include <optional>
#include <string>

namespace equistream::cli {

/// What every report in JSON says of its making: `command` as typed, `version` of equistream, and `machine` with `cpu`
/// and `threads`.
nlohmann::ordered_json provenance(const std::string& command);

/// Null where there is no value.
template <typename Value>
nlohmann::ordered_json or_null(const std::optional<Value>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

}  // namespace equistream::cli
