#pragma once
/// Options that only this host has.
#include "world_map.h"

#include <host-adapters/common/host.h>
#include <programs/cli/program.h>

#include <cstdint>
#include <memory>
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
void add_host_options(cli::CommandLine& app, HostOptions& options);

/// Throws InputError when an option that only XML has is given with a scene of ours.
void require_xml_options_unused(const cli::CommandLine& app);

// Where a scene comes from: a description of ours, or a user's XML. Both end as one EmbeddedScene.

/// What a source loads with.
struct LoadContext {
    const Engine& engine;
    const render_command::RenderOptions& options;
    const HostOptions& host;
    std::vector<SensorRequest> sensors;
    std::string aovs;
};

class SceneSource {
public:
    virtual ~SceneSource() = default;
    virtual const SceneDescription& description() const = 0;
    virtual EmbeddedScene& scene() = 0;
    virtual const WorldMap& world() const = 0;
    /// Once the frames are known.
    virtual void prepare(const render_command::Timeline& timeline) = 0;
    /// Once the frames that are there are found to be this scene's.
    virtual void begin() {}
    virtual void move_to(const render_command::FrameTimes& times) = 0;
    /// Such as "converted in 0.4 s, 1.2 M triangles".
    virtual std::string figures() const = 0;
    /// Names code outside of this process that decides pixels: " converter 0123abcd"; empty where there is none.
    virtual std::string code() const { return {}; }
    /// What the ids of its objects and materials are called.
    virtual render_command::HostNames names() const = 0;
};

/// By the file's extension: .xml is the user's own.
std::unique_ptr<SceneSource> open_scene(const LoadContext& context);

}  // namespace equistream::mitsuba_host
