/// Texts that describe: a sequence, a scene, a path.
#include "target.h"

#include <equistream/error.h>
#include <equistream/sequence.h>
#include <scenes/library/scene.h>
#include <tests/unit/plugin/export/frame_fixture.h>
#include <tests/unit/scenes/gltf_builder.h>

#include <array>
#include <cmath>

namespace equistream::fuzz {

// manifest.json of a sequence's folder.

namespace {

void take_manifest(Bytes bytes) {
    const Manifest found = read_manifest(scratch_file("manifest.json", bytes).parent_path());
    const FrameInfo& info = found.shared;
    require(width_of(info.camera) >= 1 && width_of(info.camera) <= max_image_side, "sizes are limited");
    require(std::isfinite(info.time_s) && std::isfinite(info.exposure), "numbers are finite");
    // What was accepted can be written and read again.
    const std::filesystem::path folder = scratch_file("manifest.json", {}).parent_path();
    write_manifest(folder, found);
    const std::vector<std::uint8_t> written = bytes_of_file(folder / "manifest.json");
    OneRender render(folder);
    render.require(folder, info);
    write_manifest(folder, read_manifest(folder));
    require(bytes_of_file(folder / "manifest.json") == written, "a manifest read again is the same");
    try {
        render.require(folder, testing::test_info(960, 480));
    } catch (const InputError&) {
        return;  // frames of another render
    }
}

constexpr std::array<std::string_view, 22> manifest_words = {
    "\"window_columns\": 256,",
    "\"window_columns\":",
    "\"denoiser\": 3,",
    "\"accumulated_frames\": -1,",
    "\"single_part\": 1,",
    "\"patches\": {\"side\": 16, \"columns\": 2, \"rows\": 1, \"offsets_m\": [[0, 0, 0.1]]},",
    "\"perspective\"",
    "\"equirect\"",
    "\"fov_x_rad\": 1,",
    "\"left\"",
    "\"path\"",
    "16",
    "256",
    "64",
    "3.2",
    "-3.2",
    "1.6",
    "[\"a\"]",
    "[2, 0, 0, 0]",
    "[[0, 0]]",
    "[[9, 9, 9]]",
    "18446744073709551615"};

void damage_manifest(std::vector<std::uint8_t>& bytes, std::mt19937& random) {
    damage_text(manifest_words, bytes, random);
}

Seeds manifest_seeds() {
    Manifest manifest;
    manifest.shared = testing::test_info(960, 480);
    manifest.planes = {"colour", "depth"};
    manifest.command = "equistream render \"a b\"";
    manifest.fingerprint = "0123abcd";
    const std::filesystem::path folder = scratch_file("manifest.json", {}).parent_path();
    Seeds seeds;
    const auto add = [&] {
        write_manifest(folder, manifest);
        seeds.push_back(bytes_of_file(folder / "manifest.json"));
    };
    add();
    manifest.shared.camera = PerspectiveCamera{640, 360, 1.5};
    manifest.shared.denoiser = "mean";
    manifest.shared.accumulated_frames = 8;
    manifest.single_part = true;
    add();
    const WindowGrid grid{256, 128, 64, 32};
    manifest.shared.camera = window_shape(grid);
    manifest.shared.window_columns = grid.columns;
    add();
    manifest.shared.window_columns = 0;
    manifest.shared.camera = EquirectCamera{64, 32, {}};
    manifest.shared.patches = PatchAtlas{64, 32, 16, {}, {{0.05, 0, 0}, {-0.05, 0, 0}}, 2, 1, {{}, {}}};
    add();
    return seeds;
}

}  // namespace

const Target manifest_target{"manifest", take_manifest, manifest_seeds, 3000, damage_manifest};

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
    "moving": [{"object": "one", "path": "walk.csv"},
        {"object": "two", "keys": [{"time_s": 0, "position_m": [0, 1, 0]}, {"time_s": 1, "position_m": [0, 2, 0]}]}],
    "model_unit_m": 0.01,
    "stands_for": "0123456789abcdef"
}
)";
constexpr std::string_view least = R"({"model": "one.glb", "sun": {"towards": [0, 2, 1], "irradiance": 1},
"camera": {"path": "walk.csv"}})";
constexpr std::string_view image = R"({"model": "one.glb", "camera": {"path": "walk.csv"},
"sky": {"image": "walk.csv", "rotation_deg": -30.5, "scale": [1, 2, 0.5]}})";
constexpr std::string_view walk = "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0,0,1,1,0,0,0\n";

/// Nodes that may move with one below them, two of one name, and one without volume.
std::vector<std::uint8_t> nodes() {
    test::GltfBuilder builder = test::GltfBuilder::triangle();
    builder.node({{"name", "two"}, {"mesh", 0}, {"children", {2}}, {"scale", {-1, 1, 1}}});
    builder.node({{"name", "below"}, {"mesh", 0}});
    builder.node({{"name", "flat"}, {"mesh", 0}, {"scale", {1, 0, 1}}});
    builder.node({{"name", "above"}, {"children", {3}}});
    builder.node({{"name", "twin"}, {"mesh", 0}});
    builder.node({{"name", "twin"}, {"mesh", 0}});
    return bytes_of(builder.glb());
}

/// What a renderer makes of its moving objects.
void move_objects(const SceneDescription& scene) {
    const SceneModel model = load_model(scene, {.shading = false});
    const std::size_t moving = find_moving_instances(model, scene).size();
    MovedInstances moved(model, scene);
    require(moved.any_moves() == (moving > 0), "what moves is told the same by both");
    for (const double time_s : {0.0, 0.5 * scene.camera_path.duration_s()})
        require(moved.at(time_s).size() == model.instances.size(), "every instance has its place");
    require(instance_transforms(model, scene, 0).size() == model.instances.size(), "the same, asked for once");
}

void take_scene(Bytes bytes) {
    static const std::filesystem::path model = scratch_file("one.glb", nodes());
    static const std::filesystem::path csv = scratch_file("walk.csv", bytes_of(walk));
    const SceneDescription scene = load_scene(scratch_file("scene.json", bytes));
    require(!scene.camera_path.empty() && !scene.model.empty(), "there is a path and a model");
    require(scene.exposure > 0 && scene.frames_per_second > 0 && scene.head_radius_m >= 0, "numbers are in range");
    require(!scene.sun || std::abs(glm::length(scene.sun->towards) - 1) < 1e-9, "the sun's direction is unit");
    const SceneDescription again = load_scene(scratch_file("scene.json", bytes_of(description_text(scene))));
    require(again.name == scene.name && again.moving.size() == scene.moving.size() &&
                again.camera_path.keys().size() == scene.camera_path.keys().size(),
            "what was accepted can be written and read again");
    move_objects(scene);
}

constexpr std::array<std::string_view, 27> scene_words = {"\"towards\": [0, 1, 0],",
                                                          "\"orientation_wxyz\": [1, 0, 0, 0],",
                                                          "\"look_at_m\": [0, 0, 1],",
                                                          "\"path\": \"walk.csv\",",
                                                          "\"keys\": [],",
                                                          "\"image\": \"walk.csv\",",
                                                          "\"radiance\": 1,",
                                                          "\"rotation_deg\": 3,",
                                                          "\"scale\": 2,",
                                                          "\"angular_radius_deg\": 91,",
                                                          "\"name\": 3,",
                                                          "\"model_unit_m\": 1e7,",
                                                          "\"stands_for\": \"x\",",
                                                          "\"one\"",
                                                          "\"two\"",
                                                          "\"flat\"",
                                                          "\"above\"",
                                                          "\"below\"",
                                                          "\"twin\"",
                                                          "\"one.glb\"",
                                                          "\"/one.glb\"",
                                                          "\"walk.csv\"",
                                                          "2e9",
                                                          "-2e9",
                                                          "91",
                                                          "[0, 1e10, 0]",
                                                          "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[["};

void damage_scene(std::vector<std::uint8_t>& bytes, std::mt19937& random) {
    damage_text(scene_words, bytes, random);
}

Seeds scene_seeds() {
    return {bytes_of(whole), bytes_of(least), bytes_of(image)};
}

}  // namespace

const Target scene_target{"scene", take_scene, scene_seeds, 2000, damage_scene};

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
    require(clock_note(path, "path").find('\n') == std::string::npos, "a note is one line");
    const std::filesystem::path file = scratch_file("again.csv", {});
    write_path_csv(file, path);
    const PosePath again = read_path_csv(file);
    require(again.keys().size() == path.keys().size() && again.duration_s() == path.duration_s(),
            "what was accepted can be written and read again");
    write_path_csv(file, again);
    require(path_fingerprint(read_path_csv(file)).size() == path_fingerprint(path).size(),
            "a fingerprint has its length");
}

constexpr std::array<std::string_view, 11> path_words = {
    "1764000000",          "1764000000.25",       "1764000000000", "-5", "-4",   "100000",
    "\n0,0,0,0,1,0,0,0\n", "\n1,0,0,0,1,0,0,0\n", "2000000000",    "# ", "0.999"};

void damage_path(std::vector<std::uint8_t>& bytes, std::mt19937& random) {
    damage_text(path_words, bytes, random);
}

Seeds path_seeds() {
    return {bytes_of("\xef\xbb\xbf# recorded\r\ntime_s,x,y,z,qw,qx,qy,qz\r\n\r\n0, 1,2,3, 1,0,0,0\r\n"
                     "+1,4,5,6,0,1,0,0\r\n2.5,-1e-3,5.25,6,0.6,0,0.8,0"),
            bytes_of("0,0,0,0,1,0,0,0\n"), bytes_of("1764000000.25,0,0,0,1,0,0,0\n1764000001.5,0,0,1,1,0,0,0\n"),
            bytes_of("-5,0,0,0,1,0,0,0\n-4,0,0,1,1,0,0,0\n")};
}

}  // namespace

const Target path_target{"path", take_path, path_seeds, 10000, damage_path};

}  // namespace equistream::fuzz
