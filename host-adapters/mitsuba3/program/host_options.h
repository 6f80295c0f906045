#pragma once
/// Options that only this host has.
#include <programs/cli/program.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream::mitsuba_host {

struct HostOptions {
    std::string variant;  ///< empty: choose
    std::optional<std::uint32_t> max_bounces;
    bool scene_only = false;
    // Of a user's own XML:
    std::vector<std::string> definitions;  ///< "name=value"
    int sensor = 0;
    std::string up = "auto";
    double unit_m = 1, head_radius_m = 0;

    /// Throws InputError for one that has no '='.
    std::vector<std::pair<std::string, std::string>> parameters() const;
};

/// The values are there once `app` has parsed.
void add_host_options(CLI::App& app, HostOptions& options);

/// Throws InputError when an option that only XML has is given with a scene of ours.
void require_xml_options_unused(const CLI::App& app);

}  // namespace equistream::mitsuba_host
