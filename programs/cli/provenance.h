#pragma once
#include <nlohmann/json.hpp>

#include <string>

namespace equistream::cli {

/// What every report in JSON says of its making: `command` as typed, `version` of equistream, and `machine` with `cpu`
/// and `threads`.
nlohmann::ordered_json provenance(const std::string& command);

}  // namespace equistream::cli
