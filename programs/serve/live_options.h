#pragma once
/// What `equistream serve SCENE` is told beyond what every server is.
#include "live.h"

#include <programs/cli/program.h>

#include <filesystem>
#include <string>
#include <vector>

namespace equistream::serve {

struct LiveOptions {
    std::string host = "embree", size = "480x240", path, depth = "auto";
    std::uint32_t spp = 16;
    double rate = LiveSettings{}.spheres_per_s;
    unsigned threads = 0;
    LiveCoding coding;
};

/// Whether a source is a scene rather than something rendered: by its name.
bool is_scene(const std::string& source);

void add_live_options(CLI::App& app, LiveOptions& options);
/// Throws InputError where one of them was given for what is no scene.
void require_live_options_unused(const CLI::App& app, const std::string& source);

/// `folder` is for the renderer's frames, `more` are arguments of its own. Throws InputError naming what cannot be.
LiveSettings live_settings(const LiveOptions& options, const std::string& scene, const std::filesystem::path& folder,
                           const std::vector<std::string>& more);

}  // namespace equistream::serve
