#pragma once
/// The scene as it is traced, and how it moves from frame to frame.
#include <host-adapters/embree/surfaces.h>
#include <scenes/library/scene.h>

#include <optional>
#include <vector>

namespace equistream::embree_host {

class LoadedScene {
public:
    /// `description` is borrowed. Openings to the sky are learned from places along `path`.
    LoadedScene(const SceneDescription& description, const PathOptions& options, const PosePath& path,
                unsigned threads);

    /// Moves everything to where it is at `time_s`; the neighbours' times are those of motion vectors.
    void move_to(double time_s, double previous_time_s, double next_time_s);

    const TracedScene& traced() const { return *traced_; }
    NeighbourTransforms neighbours() const { return {previous_, next_, moves_}; }
    const SceneModel& model() const { return model_; }
    double bvh_s() const { return bvh_s_; }
    const SkyOpenings& openings() const { return openings_; }
    double openings_s() const { return openings_s_; }
    std::size_t bvh_bytes() const { return bvh_->memory_bytes(); }

private:
    const SceneDescription& description_;
    SceneModel model_;
    std::vector<std::uint32_t> moving_;
    std::vector<std::uint8_t> moves_;
    std::vector<glm::mat4> now_, previous_, next_;
    std::optional<Textures> textures_;
    std::optional<ShadingScene> shading_;
    std::optional<Bvh> bvh_;
    double bvh_s_ = 0;
    Lights lights_;
    SkyOpenings openings_;
    double openings_s_ = 0;
    std::optional<TracedScene> traced_;
};

}  // namespace equistream::embree_host
