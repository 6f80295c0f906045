#pragma once
/// A scene of ours in Mitsuba: converted by `equistream-scene`, whose libraries must stay out of this process, and
/// moved frame by frame as the embedded host moves it.
#include "scene_source.h"

#include <scenes/library/scene.h>

namespace equistream::mitsuba_host {

class OwnScene : public SceneSource {
public:
    explicit OwnScene(const LoadContext& context);

    const SceneDescription& description() const override { return description_; }
    EmbeddedScene& scene() override { return *scene_; }
    const WorldMap& world() const override { return world_; }
    void prepare(const render_command::Timeline&) override {}
    void move_to(const render_command::FrameTimes& times) override;
    std::string figures() const override { return figures_; }
    std::string code() const override { return " converter " + converter_.substr(0, 8); }
    render_command::HostNames names() const override;

private:
    /// A shape of Mitsuba's and the instance that it is.
    struct MovingShape {
        std::size_t shape = 0;
        std::uint32_t instance = no_index;
        bool is_mesh = false;
        MeshBuffers at_rest;  // of a mesh: as converted, at time 0
    };

    void read_placements();
    std::filesystem::path converted(const LoadContext& context);
    void number_shapes();
    void place(const MovingShape& shape, const glm::mat4& now);

    SceneDescription description_;
    WorldMap world_;         // ours is Mitsuba's
    SceneModel placements_;  // objects and instances alone
    std::vector<glm::mat4> at_zero_;
    std::unique_ptr<EmbeddedScene> scene_;
    std::vector<MovingShape> moving_;
    std::vector<std::uint8_t> moves_;
    std::string converter_;  // fingerprint of the program that converts
    std::string figures_;
};

// A user's own scene in Mitsuba's XML: the head begins where its sensor is, and its geometry goes out as GLB beside a
// description, so that a client can play it back with local depth.

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
    render_command::HostNames names() const override;

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
