#pragma once
/// Where a scene comes from: a description of ours, or a user's XML. Both end as one EmbeddedScene.
#include "host_options.h"
#include "world_map.h"

#include <host-adapters/common/host.h>

#include <memory>

namespace equistream::mitsuba_host {

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
};

/// By the file's extension: .xml is the user's own.
std::unique_ptr<SceneSource> open_scene(const LoadContext& context);

}  // namespace equistream::mitsuba_host
