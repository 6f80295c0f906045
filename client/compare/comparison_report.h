#pragma once
/// What a comparison prints: a table for people, JSON for programs (docs/compare.md states every key).
/// In JSON a figure is null where it is infinite (identical pictures) or was not measured; "identical" tells which.
#include "comparison.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace equistream {

std::string comparison_table(const std::vector<EyeScore>& eyes, const ComparisonOptions& options);
nlohmann::ordered_json comparison_json(const std::vector<EyeScore>& eyes, const ComparisonOptions& options);

/// "35.20 dB [34.91, 35.52]", or "> 41.3 dB" where the interval reaches 0.
std::string unbiased_text(const UnbiasedError& error);

}  // namespace equistream
