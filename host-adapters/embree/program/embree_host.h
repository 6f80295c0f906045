#pragma once
/// The embedded path tracer as `equistream render` drives it.
#include <host-adapters/common/host.h>
#include <host-adapters/embree/surfaces.h>

#include <optional>

namespace equistream::embree_host {

class LoadedScene;

class EmbreeHost : public render_command::RenderHost {
public:
    EmbreeHost();
    ~EmbreeHost() override;

    render_command::HostText text() const override;
    void add_options(cli::CommandLine& app) override;
    const SceneDescription& describe(const render_command::RenderOptions& options) override;
    void load(const render_command::RenderOptions& options, const render_command::Timeline& timeline) override;
    render_command::HostRecord record() const override;
    render_command::HostNames names() const override;
    void move_to(const render_command::FrameTimes& times) override;
    void cast(std::span<const es_ray> rays, std::span<float> distances_m) override;
    void render(const render_command::FrameTask& task) override;
    render_command::HostFigures figures(double render_s, nlohmann::json& json) const override;

private:
    PathOptions path_options_;
    SceneDescription description_;
    std::unique_ptr<LoadedScene> scene_;
    unsigned threads_ = 1;
    RayCounts counts_;
};

}  // namespace equistream::embree_host
