#pragma once
/// A user's own scene in Mitsuba's XML: the head begins where its sensor is, and its geometry goes out as GLB beside a
/// description, so that a client can play it back with local depth.
#include "scene_source.h"

namespace equistream::mitsuba_host {

class XmlScene : public SceneSource {
public:
    explicit XmlScene(const LoadContext& context);
    ~XmlScene() override;

    const SceneDescription& description() const override { return description_; }
    EmbeddedScene& scene() override { return *scene_; }
    const WorldMap& world() const override { return world_; }
    void prepare(const render_command::Timeline& timeline) override;
    void begin() override;
    void move_to(const render_command::FrameTimes&) override {}
    std::string figures() const override { return figures_; }

private:
    std::filesystem::path out_;
    std::filesystem::path prepared_;  // scene.glb and scene.json, until it is known that they may be put into out_
    double ipd_m_ = 0;
    SceneDescription description_;
    WorldMap world_;
    std::unique_ptr<EmbeddedScene> scene_;
    std::string figures_;
};

}  // namespace equistream::mitsuba_host
