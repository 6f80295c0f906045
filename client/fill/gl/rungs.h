#pragma once
/// Rungs of the fill ladder (fill.h) that there are on the GPU.
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::gl {

enum class Rung { hidden, patches, earlier, small, small_wide, geometry, push_pull, spread };
inline constexpr std::array<std::string_view, 8> rung_names = {"hidden",     "patches",  "earlier",  "small",
                                                               "small-wide", "geometry", "pushpull", "spread"};

/// Of a comma-separated list, in its order; "none" alone: of none. Throws InputError naming the accepted words.
std::vector<Rung> parse_rungs(const std::string& list);

}  // namespace equistream::gl
