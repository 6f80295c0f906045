#pragma once
/// Rungs of the fill ladder (fill.h) that there are on the GPU.
#include <string>
#include <vector>

namespace equistream::gl {

enum class Rung { hidden, patches, earlier, small, push_pull };

/// Of a comma-separated list, in its order; "none" alone: of none. Throws InputError naming the accepted words
/// (parse_fills).
std::vector<Rung> parse_rungs(const std::string& list);

/// The list with what stands for the rungs that the CPU alone has: `small` for `small-wide`, `pushpull` for `spread`,
/// nothing for `geometry`. Adds a line to `notes` for each.
std::string with_rungs_of_gpu(const std::string& list, std::vector<std::string>& notes);

}  // namespace equistream::gl
