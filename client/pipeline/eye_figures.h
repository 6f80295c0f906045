#pragma once
/// What became of one eye's pixels.
#include <client/fill/fill.h>
#include <client/reflections/specular.h>

#include <cstdint>
#include <optional>

namespace equistream {

struct EyeFigures {
    std::int64_t pixels = 0;
    std::int64_t gaps = 0;                ///< what the source did not see
    SpecularCounts specular{};            ///< mirrors and glass
    FilledCounts filled{};                ///< by each pass, in order
    std::optional<double> reliability{};  ///< the pixels' mean, 0 to 1, where it was estimated
};

}  // namespace equistream
