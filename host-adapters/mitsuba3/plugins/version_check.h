#pragma once
/// Mitsuba never asks which release a plugin was compiled for; a plugin of another one crashes or renders nonsense.
#include <string>

namespace equistream::mitsuba_host {

/// The release in the first line of util::info_build(), such as "3.9.1"; empty if it names none.
std::string release_in(const std::string& info_build);

/// Throws std::runtime_error, one line, unless `info_build` names the release `expected`.
void require_release(const std::string& plugin, const std::string& info_build, const std::string& expected);

}  // namespace equistream::mitsuba_host
