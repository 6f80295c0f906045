#pragma once
/// Scenes written for Mitsuba 0.6. Mitsuba 3 stops at the first thing that it no longer knows.
#include <filesystem>
#include <string>
#include <vector>

namespace equistream::mitsuba_xml {

/// All that must be changed in a scene's XML and in the files it includes before Mitsuba 3 reads it, one sentence each:
/// "FILE:LINE: write <rgb> in place of <srgb>". Empty where nothing of Mitsuba 0.6 is found. Throws InputError where a
/// file cannot be read or is no XML.
std::vector<std::string> changes_for_mitsuba3(const std::filesystem::path& xml);

}  // namespace equistream::mitsuba_xml
