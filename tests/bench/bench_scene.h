#pragma once
/// Scenes that figures are taken on: loaded at the first use, kept to the end.
#include <client/depth/ray_depth.h>
#include <scenes/embree/bvh.h>
#include <scenes/library/scene.h>

#include <optional>
#include <string>

namespace equistream::bench {

/// A scene as the client has it, and Embree on the same geometry for peers.
struct BenchScene {
    explicit BenchScene(const SceneDescription& scene);

    SceneDescription description;
    RayDepth depth;
    SceneModel model;
    SceneModel model_without_masks;
    Bvh bvh;
    Bvh bvh_without_masks;
};

/// The bundled scene, or one of EQUISTREAM_SCENES; none where that is not set.
std::optional<SceneDescription> bench_description(const std::string& name);
/// Of it; null where there is none.
BenchScene* bench_scene(const std::string& name);

}  // namespace equistream::bench
