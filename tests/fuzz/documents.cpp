/// Texts that describe: a sequence, a scene, a path.
#include "target.h"

#include <equistream/sequence.h>
#include <scenes/library/scene.h>
#include <tests/unit/plugin/export/frame_fixture.h>
#include <tests/unit/scenes/gltf_builder.h>

#include <cmath>

namespace equistream::fuzz {

// manifest.json of a sequence's folder.

namespace {

void take_manifest(Bytes bytes) {
    const Manifest found = read_manifest(scratch_file("manifest.json", bytes).parent_path());
    const FrameInfo& info = found.shared;
    require(width_of(info.camera) >= 1 && width_of(info.camera) <= max_image_side, "sizes are limited");
    require(std::isfinite(info.time_s) && std::isfinite(info.exposure), "numbers are finite");
}

Seeds manifest_seeds() {
    Manifest manifest;
    manifest.shared = testing::test_info(960, 480);
    manifest.planes = {"colour", "depth"};
    manifest.command = "equistream render \"a b\"";
    manifest.fingerprint = "0123abcd";
    const std::filesystem::path folder = scratch_file("manifest.json", {}).parent_path();
    Seeds seeds;
    for (const Camera& camera : {Camera(EquirectCamera{960, 480, {}}), Camera(PerspectiveCamera{640, 360, 1.5})}) {
        manifest.shared.camera = camera;
        write_manifest(folder, manifest);
        seeds.push_back(bytes_of_file(folder / "manifest.json"));
    }
    return seeds;
}

}  // namespace

const Target manifest_target{"manifest", take_manifest, manifest_seeds, 15000};

// A scene's description (JSON); a model and a path that it may name lie beside it.

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

void take_scene(Bytes bytes) {
    static const std::filesystem::path model = scratch_file("one.glb", bytes_of(test::GltfBuilder::triangle().glb()));
    static const std::filesystem::path csv = scratch_file("walk.csv", bytes_of(walk));
    const SceneDescription scene = load_scene(scratch_file("scene.json", bytes));
    require(!scene.camera_path.empty() && !scene.model.empty(), "there is a path and a model");
    require(scene.exposure > 0 && scene.frames_per_second > 0 && scene.head_radius_m >= 0, "numbers are in range");
    require(!scene.sun || std::abs(glm::length(scene.sun->towards) - 1) < 1e-9, "the sun's direction is unit");
}

Seeds scene_seeds() {
    return {bytes_of(whole), bytes_of(least), bytes_of(image)};
}

}  // namespace

const Target scene_target{"scene", take_scene, scene_seeds, 20000};

// A camera or head path (CSV).

namespace {

void take_path(Bytes bytes) {
    const PosePath path = read_path_csv(scratch_file("path.csv", bytes));
    require(!path.empty(), "there is a key");
    const double first = path.keys().front().time_s;
    for (const double time_s : {first - 1, first, 0.5 * (first + path.duration_s()), path.duration_s() + 1}) {
        const Pose pose = path.at(time_s);
        require(std::isfinite(pose.position_m.x) && std::abs(glm::length(pose.orientation) - 1) < 1e-6,
                "every pose between is a pose");
    }
}

Seeds path_seeds() {
    return {bytes_of("\xef\xbb\xbf# recorded\r\ntime_s,x,y,z,qw,qx,qy,qz\r\n\r\n0, 1,2,3, 1,0,0,0\r\n"
                     "+1,4,5,6,0,1,0,0\r\n2.5,-1e-3,5.25,6,0.6,0,0.8,0"),
            bytes_of("0,0,0,0,1,0,0,0\n")};
}

}  // namespace

const Target path_target{"path", take_path, path_seeds, 20000};

}  // namespace equistream::fuzz
