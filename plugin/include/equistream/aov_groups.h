#pragma once
/// The lists by which users choose AOVs.
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

/// Plane names of a comma-separated list of groups ("depth,motion,normal,albedo,ids", "all" or "none"), in the order of
/// the AOV catalogue: colour is always first. Throws InputError naming the unknown word and the accepted ones.
/// `only_in_all`: refuses groups that "all" leaves out.
std::vector<std::string> parse_aov_groups(std::string_view list, bool only_in_all = false);

}  // namespace equistream
