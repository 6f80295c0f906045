#pragma once
/// Rungs of the fill ladder (fill.h) that there are on the GPU.
#include <string>
#include <vector>

namespace equistream::gl {

enum class Rung { hidden, patches, earlier, small, small_wide, geometry, push_pull, spread };

/// Of a comma-separated list, in its order; "none" alone: of none. Throws InputError naming the accepted words
/// (parse_fills).
std::vector<Rung> parse_rungs(const std::string& list);

}  // namespace equistream::gl
