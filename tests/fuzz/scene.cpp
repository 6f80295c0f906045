/// A scene's description (JSON); a model and a path that it may name lie beside it.
#include "target.h"

#include <scenes/library/scene.h>
#include <tests/unit/scenes/gltf_builder.h>

#include <cmath>

namespace equistream::fuzz {

namespace {

constexpr std::string_view whole = R"({
    "name": "a scene",
    "model": "one.glb",
    "sun": {"azimuth_deg": 30, "elevation_deg": 60, "irradiance": [3, 2.5, 2], "angular_radius_deg": 0.3},
    "sky": {"radiance": 0.4},
    "camera": {"keys": [
        {"time_s": 0, "position_m": [0, 1.6, 0], "look_at_m": [0, 1.5, -4]},
        {"time_s": 2.5, "position_m": [1, 1.6, -1e-1], "orientation_wxyz": [0.8, 0, 0.6, 0]}]},
    "head_box": {"lean_m": 0.1},
    "exposure": 1.5,
    "frames_per_second": 29.97,
    "moving": [{"object": "one", "path": "walk.csv"}]
}
)";
constexpr std::string_view least = R"({"model": "one.glb", "sun": {"towards": [0, 2, 1], "irradiance": 1},
"camera": {"path": "walk.csv"}})";
constexpr std::string_view image = R"({"model": "one.glb", "camera": {"path": "walk.csv"},
"sky": {"image": "walk.csv", "rotation_deg": -30.5, "scale": [1, 2, 0.5]}})";
constexpr std::string_view walk = "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0,0,1,1,0,0,0\n";

void read(Bytes bytes) {
    static const std::filesystem::path model = scratch_file("one.glb", bytes_of(test::GltfBuilder::triangle().glb()));
    static const std::filesystem::path csv = scratch_file("walk.csv", bytes_of(walk));
    const SceneDescription scene = load_scene(scratch_file("scene.json", bytes));
    require(!scene.camera_path.empty() && !scene.model.empty(), "there is a path and a model");
    require(scene.exposure > 0 && scene.frames_per_second > 0 && scene.head_radius_m >= 0, "numbers are in range");
    require(!scene.sun || std::abs(glm::length(scene.sun->towards) - 1) < 1e-9, "the sun's direction is unit");
}

Seeds seeds() {
    return {bytes_of(whole), bytes_of(least), bytes_of(image)};
}

}  // namespace

const Target scene_target{"scene", read, seeds, 20000};

}  // namespace equistream::fuzz
