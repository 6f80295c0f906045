#pragma once
/// Mitsuba as `equistream render` drives it.
#include "scene_source.h"

#include <host-adapters/common/host.h>

#include <optional>

namespace equistream::mitsuba_host {

class MitsubaHost : public render_command::RenderHost {
public:
    render_command::HostText text() const override;
    void add_options(cli::CommandLine& app) override;
    const SceneDescription& describe(const render_command::RenderOptions& options) override;
    void load(const render_command::RenderOptions& options, const render_command::Timeline& timeline) override;
    void begin() override;
    bool wants_frames() const override { return !host_options_.scene_only; }
    render_command::HostRecord record() const override;
    render_command::HostNames names() const override;
    void move_to(const render_command::FrameTimes& times) override;
    void cast(std::span<const es_ray> rays, std::span<float> distances_m) override;
    void render(const render_command::FrameTask& task) override;
    int tile_side() const override { return 1024; }
    bool fills_tiles() const override { return false; }
    render_command::HostFigures figures(double render_s, nlohmann::json& json) const override;

private:
    void render_planes(const render_command::FrameTask& task);
    void render_tiles(const render_command::FrameTask& task, bool ids_alone);
    std::size_t sensor_of(const render_command::StreamSettings& stream) const;
    Camera camera_of(const render_command::FrameTask& task) const;
    std::uint32_t seed_of(std::int64_t frame, std::size_t sensor, std::uint32_t pass) const;

    const cli::CommandLine* app_ = nullptr;
    HostOptions host_options_;
    render_command::RenderOptions options_;
    std::string rendered_aovs_;
    std::filesystem::path plugin_root_;
    std::optional<Engine> engine_;  // outlives the scene
    std::unique_ptr<SceneSource> source_;
    std::uint64_t left_out_samples_ = 0;
    double mitsuba_s_ = 0;
};

}  // namespace equistream::mitsuba_host
