#include <tests/unit/scenes/gltf_builder.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <scenes/library/file_bytes.h>
#include <scenes/library/scene.h>

#include <equistream/elapsed.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace equistream::test {

namespace {

class SceneTest : public TemporaryFolder {
protected:
    SceneTest() {
        unsetenv("EQUISTREAM_SCENES");
        write("model.glb", GltfBuilder::triangle().glb());
    }
    SceneDescription load(const std::string& text) const { return load_scene(write("scene.json", text)); }
    /// The error without the folder.
    std::string error(const std::string& text) const {
        const std::string message = input_error([&] { load(text); });
        EXPECT_EQ(message.rfind(folder_.string() + "/", 0), 0u) << message;
        return message.substr(std::min(message.size(), folder_.string().size() + 1));
    }
    /// A description whose camera has this one key.
    std::string key_error(const std::string& key) const {
        return error("{\"model\": \"model.glb\",\n\"camera\": {\"keys\": [\n" + key + "\n]}}");
    }
};

constexpr const char* least = R"({"model": "model.glb", "camera": {"keys": [{"time_s": 0, "position_m": [1, 2, 3]}]}})";

constexpr const char* full = R"({
  "name": "a yard",
  "model": "model.glb",
  "sun": {"azimuth_deg": 90, "elevation_deg": 30, "irradiance": [3, 2, 1], "angular_radius_deg": 1},
  "sky": {"radiance": 0.5},
  "camera": {"keys": [
    {"time_s": 0, "position_m": [0, 0, 0], "look_at_m": [5, 0, 0]},
    {"time_s": 2, "position_m": [0, 0, 1], "orientation_wxyz": [0, 0, 1, 0]}
  ]},
  "head_box": {"lean_m": 0.25},
  "exposure": 0.8,
  "frames_per_second": 24,
  "moving": [{"object": "one", "path": "walk.csv"}]
})";

}  // namespace

TEST_F(SceneTest, LeastDescription) {
    const SceneDescription scene = load(least);
    EXPECT_EQ(scene.name, "scene");
    EXPECT_FALSE(scene.sun.has_value());
    EXPECT_EQ(scene.camera_path.at(0).position_m, glm::dvec3(1, 2, 3));
    EXPECT_EQ(scene.camera_path.at(0).orientation, glm::dquat(1, 0, 0, 0));
    EXPECT_EQ(scene.exposure, 1);
    EXPECT_EQ(scene.frames_per_second, 30);
    EXPECT_EQ(scene.head_radius_m, 0);
    EXPECT_EQ(load_model(scene.model).triangle_count(), 1u);
}

/// Recorded by one clock.
TEST_F(SceneTest, MovingObjectsAreOnTheCamerasClock) {
    write("walk.csv", "1763958005,1,2,3,1,0,0,0\n1763958007,3,2,3,1,0,0,0\n");
    const SceneDescription scene = load(R"({"model": "model.glb",
        "camera": {"keys": [{"time_s": 1763958000, "position_m": [0, 0, 0]}, {"time_s": 1763958010, "position_m": [1, 0, 0]}]},
        "moving": [{"object": "one", "path": "walk.csv"}]})");
    EXPECT_EQ(scene.camera_path.duration_s(), 10);
    EXPECT_EQ(scene.moving[0].path.at(5).position_m.x, 1);
    EXPECT_EQ(scene.moving[0].path.at(6).position_m.x, 2);
}

TEST_F(SceneTest, FullDescription) {
    write("walk.csv", "0,1,2,3,1,0,0,0\n");
    const SceneDescription scene = load(full);
    EXPECT_EQ(scene.name, "a yard");
    ASSERT_TRUE(scene.sun.has_value());
    // Azimuth 90 degrees is +X, elevation 30 lifts it by sin 30 = 1/2.
    EXPECT_NEAR(glm::length(scene.sun->towards - glm::dvec3(std::sqrt(0.75), 0.5, 0)), 0, 1e-12);
    EXPECT_EQ(scene.sun->irradiance, glm::dvec3(3, 2, 1));
    EXPECT_NEAR(scene.sun->angular_radius_rad, std::acos(-1.0) / 180, 1e-15);
    EXPECT_EQ(scene.sky_radiance, glm::dvec3(0.5));
    const glm::dvec3 forward = scene.camera_path.at(0).orientation * glm::dvec3(0, 0, -1);
    EXPECT_NEAR(glm::length(forward - glm::dvec3(1, 0, 0)), 0, 1e-12);
    const glm::dvec3 up = scene.camera_path.at(0).orientation * glm::dvec3(0, 1, 0);
    EXPECT_NEAR(glm::length(up - glm::dvec3(0, 1, 0)), 0, 1e-12);
    EXPECT_EQ(scene.head_radius_m, 0.25);
    EXPECT_EQ(scene.exposure, 0.8);
    EXPECT_EQ(scene.frames_per_second, 24);
    ASSERT_EQ(scene.moving.size(), 1u);
    EXPECT_EQ(scene.moving[0].path.at(0).position_m, glm::dvec3(1, 2, 3));
}

TEST_F(SceneTest, UnknownAndRepeatedKeysNameTheirLine) {
    EXPECT_EQ(error("{\n \"sunn\": 1,\n \"model\": \"model.glb\"}"),
              "scene.json:2: expected one of name, model, model_unit_m, sun, sky, camera, head_box, exposure, "
              "frames_per_second, moving, stands_for, found \"sunn\"");
    EXPECT_EQ(error("{\"model\": \"a\",\n\n\"model\": \"b\"}"),
              "scene.json:3: expected each key once, found \"model\" again after line 1");
    expect_contains(
        key_error(R"({"time_s": 0, "position": [0, 0, 0]})"),
        "scene.json:3: expected one of time_s, position_m, look_at_m, orientation_wxyz, found \"position\"");
}

TEST_F(SceneTest, ManyKeysTakeNoTime) {
    std::string text = "{";
    for (int i = 0; i < 300000; ++i)
        text += "\"k" + std::to_string(i) + "\":0,";
    const auto start = Clock::now();
    expect_contains(error(text + "\"k\":0}"), "found \"k0\"");
    expect_contains(error(text + "\"k7\":0}"), "expected each key once, found \"k7\" again");
    EXPECT_LT(seconds_since(start), 10);
}

TEST_F(SceneTest, ManyPartsOfAMovingObjectTakeNoTime) {
    SceneModel model;
    SceneDescription scene;
    constexpr int count = 50000;  // each the child of the one before
    for (int i = 0; i < count; ++i) {
        model.objects.push_back({"node " + std::to_string(i), i - 1, glm::mat4(1)});
        model.instances.push_back({0, static_cast<std::uint32_t>(i), glm::mat4(1)});
    }
    scene.moving = {{"node 1", PosePath({{0, {}}}, "here")}, {"node 40000", PosePath({{0, {{1, 0, 0}}}}, "here")}};
    const auto start = Clock::now();
    EXPECT_EQ(find_moving_instances(model, scene).size(), std::size_t{count - 1});
    const std::vector<glm::mat4> placed = instance_transforms(model, scene, 0);
    EXPECT_LT(seconds_since(start), 5);
    EXPECT_EQ(placed[39999][3].x, 0);
    EXPECT_EQ(placed[40000][3].x, 1);
    EXPECT_EQ(placed.back()[3].x, 1);
}

TEST_F(SceneTest, AFilesNameInOtherBytesIsTakenAsAManifestHoldsIt) {
    write("model.glb", GltfBuilder::triangle().glb());
    const auto name_of = [&](const std::string& file) {
        const std::string text =
            R"({"model": "model.glb", "camera": {"keys": [{"time_s": 0, "position_m": [0, 0, 0]}]}})";
        return load_scene(write(file + ".json", text)).name;
    };
    EXPECT_EQ(name_of("caf\xc3\xa9"), "caf\xc3\xa9");
    EXPECT_EQ(name_of("caf\xe9"), "caf\xef\xbf\xbd");
    EXPECT_EQ(scene_name_of("rooms/caf\xe9.xml"), "caf\xef\xbf\xbd") << "as scenes in XML are named";
    EXPECT_EQ(name_of(std::string(250, '\xe9')).size(), 255u) << "85 times three bytes";
}

TEST_F(SceneTest, RatesThatNoRenderTakesAreRefused) {
    const std::string rest =
        ", \"model\": \"model.glb\", \"camera\": {\"keys\": [{\"time_s\": 0, \"position_m\": [0,0,0]}]}}";
    expect_contains(error("{\"frames_per_second\": 1e300" + rest), "expected a number of at most 1000 as frames_per");
}

TEST_F(SceneTest, WrongValuesNameTheirLine) {
    expect_contains(error("{\"model\": 3}"), "scene.json:1");
    expect_contains(error("{\"model\": \"model.glb\",\n \"exposure\": -1,\n \"camera\": {\"keys\": "
                          "[{\"time_s\": 0, \"position_m\": [0,0,0]}]}}"),
                    "scene.json:2: expected a number from 1e-12 to 1000000000000.0 as exposure, found -1.0");
    for (const char* bad : {"\"exposure\": 1e300", "\"exposure\": 0", "\"head_box\": {\"lean_m\": 1e300}",
                            "\"head_box\": {\"lean_m\": -1}"})
        expect_contains(error("{\"model\": \"model.glb\",\n " + std::string(bad) +
                              ",\n \"camera\": {\"keys\": [{\"time_s\": 0, \"position_m\": [0,0,0]}]}}"),
                        "scene.json:2: expected a number from ");
    expect_contains(key_error(R"({"time_s": 0, "position_m": [0, "north", 0]})"),
                    "scene.json:3: expected a number as camera.keys[0].position_m[1], found \"north\"");
    expect_contains(key_error(R"({"time_s": 0, "position_m": [0, 1]})"), "a list of 3 numbers");
    expect_contains(key_error(R"({"time_s": 0, "position_m": [0, 1e300, 0]})"),
                    "scene.json:3: expected coordinates from -1e9 to 1e9 metres as camera.keys[0].position_m");
    expect_contains(key_error(R"({"time_s": 0})"), "scene.json:3: expected the key \"position_m\" in camera.keys[0]");
    EXPECT_EQ(key_error(R"({"time_s": 0, "position_m": [0,0,0], "look_at_m": [0,5.5,0]})"),
              "scene.json:3: expected a point that is not straight above, below or at position_m as "
              "camera.keys[0].look_at_m, found [0, 5.5, 0]");
    expect_contains(key_error(R"({"time_s": 0, "position_m": [0,0,0], "orientation_wxyz": [1,1,0,0]})"), "unit");
    expect_contains(key_error("{\"time_s\": 1, \"position_m\": [0,0,0]},\n{\"time_s\": 1, \"position_m\": [0,0,0]}"),
                    "scene.json:4: expected a time after");
    expect_contains(key_error(""), "at least one key");
    expect_contains(error(R"({"model": "model.glb"})"), "\"camera\"");
    expect_contains(error(R"({"model": "model.glb", "camera": {}})"), "one of keys and path");
    expect_contains(error(R"([1])"), "an object with the keys");
}

TEST_F(SceneTest, BrokenJsonNamesTheLine) {
    EXPECT_EQ(key_error(R"({"time_s": 0, "position_m": [0, NaN, 0]})"),
              "scene.json:3:33: expected a value, found \"NaN\"");
    EXPECT_EQ(key_error(R"({"time_s": 0, "position_m": [0, 1e999, 0]})"),
              "scene.json:3:33: expected a number that a double can hold, found \"1e999\"");
    EXPECT_EQ(error("{\n\"model\": \"model.glb\",\n"),
              "scene.json:3:1: expected a key in quotes, found the end of the file");
    EXPECT_EQ(error(""), "scene.json:1:1: expected a value, found the end of the file");
    const std::string cut = std::string(full).substr(0, 300);
    expect_contains(error(cut), "scene.json:" + std::to_string(1 + std::count(cut.begin(), cut.end(), '\n')) + ":");
    expect_contains(error(std::string(500, '[')), "levels of nesting");
}

TEST_F(SceneTest, BrokenJsonIsToldInPlainWords) {
    EXPECT_EQ(error(std::string(least) + "\n foo"), "scene.json:2:2: expected the end of the file, found \"foo\"");
    EXPECT_EQ(error(std::string(least) + "}"),
              "scene.json:1:" + std::to_string(std::strlen(least) + 1) + ": expected the end of the file, found \"}\"");
    EXPECT_EQ(error("{\"model\": \"model.glb\"\n  \"camera\": {}}"),
              "scene.json:2:3: expected a comma or }, found \"camera\"");
    EXPECT_EQ(error("{\"exposure\": 1\n\"camera\": {}}"), "scene.json:2:1: expected a comma or }, found \"camera\"");
    EXPECT_EQ(error("{\"exposure\": 01}"), "scene.json:1:15: expected a comma or }, found \"1\"");
    EXPECT_EQ(error("{\"a\": [1 2]}"), "scene.json:1:10: expected a comma or ], found \"2\"");
    EXPECT_EQ(error("{\"a\" 1}"), "scene.json:1:6: expected a colon behind the key, found \"1\"");
    EXPECT_EQ(error("{\"a\": 1,}"), "scene.json:1:9: expected a key in quotes, found \"}\"");
    EXPECT_EQ(error("{\"a\": [1,]}"), "scene.json:1:10: expected a value, found \"]\"");
    EXPECT_EQ(error("{\"a\": /home/me}"), "scene.json:1:7: expected a value, found \"/home/me\"");
    EXPECT_EQ(error("{\"a\": 1,\n// mine\n\"b\": 2}"),
              "scene.json:2:1: expected a key in quotes, found a comment, which JSON does not have");
    EXPECT_EQ(error("{\"a\": \"open\n}"), "scene.json:1:7: expected text in UTF-8 on one line, with JSON's escapes and "
                                          "a quote at its end, found \"open");
}

TEST_F(SceneTest, LinesAreExactAfterNumbers) {
    // A number's end is seen only one character later: its own line must not count the newline behind it.
    EXPECT_EQ(error("{\"model\": \"model.glb\", \"exposure\":\n0\n,\n\"camera\": {\"keys\": [{\"time_s\": 0, "
                    "\"position_m\": [0,0,0]}]}}")
                  .substr(0, 13),
              "scene.json:2:");
}

TEST_F(SceneTest, ModelIsFoundBesideOrBelowEquistreamScenes) {
    std::string text = R"({"model": "far.glb", "camera": {"keys": [{"time_s": 0, "position_m": [1, 2, 3]}]}})";
    std::string message = error(text);
    expect_contains(message, "scene.json:1");
    expect_contains(message, (folder_ / "far.glb").string());
    expect_contains(message, "EQUISTREAM_SCENES is not set");
    const std::filesystem::path model = write("scenes/far/far.glb", GltfBuilder::triangle().glb());
    setenv("EQUISTREAM_SCENES", (folder_ / "scenes").c_str(), 1);
    EXPECT_EQ(load(text).model, model);
    std::filesystem::remove(model);
    message = error(text);
    expect_contains(message, (folder_ / "scenes/far.glb").string());
    expect_contains(message, model.string());
    unsetenv("EQUISTREAM_SCENES");
}

TEST_F(SceneTest, SkyImagesAreFoundAsModelsAreAndFingerprinted) {
    const auto with_sky = [](const std::string& sky) {
        return "{\"model\": \"model.glb\",\n\"sky\": " + sky +
               ",\n\"camera\": {\"keys\": [{\"time_s\": 0, \"position_m\": [0, 0, 0]}]}}";
    };
    const std::string sky = R"({"image": "dawn.exr", "rotation_deg": 90, "scale": [1, 2, 3]})";
    expect_contains(error(with_sky(sky)), "scene.json:2: expected the image at one of ");
    const std::filesystem::path shared = write("scenes/dawn/dawn.exr", "far");
    setenv("EQUISTREAM_SCENES", (folder_ / "scenes").c_str(), 1);
    EXPECT_EQ(load(with_sky(sky)).sky_image->file, shared);
    unsetenv("EQUISTREAM_SCENES");
    const std::filesystem::path beside = write("dawn.exr", "near");
    const SceneDescription scene = load(with_sky(sky));
    ASSERT_TRUE(scene.sky_image.has_value());
    EXPECT_EQ(scene.sky_image->file, beside);
    EXPECT_NEAR(scene.sky_image->rotation_rad, std::acos(0.0), 1e-15);
    EXPECT_EQ(scene.sky_image->scale, glm::dvec3(1, 2, 3));
    EXPECT_EQ(scene.sky_radiance, glm::dvec3(0));
    write("dawn.exr", "other");
    EXPECT_NE(load(with_sky(sky)).fingerprint, scene.fingerprint);
    EXPECT_EQ(load(with_sky(sky)).geometry_fingerprint, scene.geometry_fingerprint);
    EXPECT_EQ(load(with_sky(R"({"image": "dawn.exr"})")).sky_image->scale, glm::dvec3(1));

    expect_contains(error(with_sky(R"({"image": "dawn.exr", "radiance": 1})")),
                    "scene.json:2: expected one of radiance and image");
    expect_contains(error(with_sky("{}")), "scene.json:2: expected one of radiance and image");
    expect_contains(error(with_sky(R"({"radiance": 1, "scale": 2})")), "expected an image to go with it as sky.scale");
    expect_contains(error(with_sky(R"({"image": "dawn.exr", "scale": -1})")), "sky.scale");
    expect_contains(error(with_sky(R"({"image": "dawn.exr", "scale": [1, 1, 1e13]})")),
                    "scene.json:2: expected numbers up to 1e12 as sky.scale");
}

TEST_F(SceneTest, AnHourOfAHeadFitsIntoADescription) {
    const auto with_keys = [](int count) {
        std::vector<PosePath::Key> keys;
        for (int i = 0; i < count; ++i) {
            const double x = std::sqrt(i + 2.0), y = -std::cbrt(i + 2.0), turn = 0.5 * std::sin(x);
            keys.push_back(
                {3599 + i / 90.0,
                 {{x, y, x * y}, glm::dquat(std::cos(turn), 0.6 * std::sin(turn), 0.0, 0.8 * std::sin(turn))}});
        }
        SceneDescription scene;
        scene.file = "walk.xml";
        scene.camera_path = PosePath(std::move(keys), "test");
        return scene;
    };
    const double bytes_of_a_key =
        0.01 * double(description_text(with_keys(200)).size() - description_text(with_keys(100)).size());
    EXPECT_GT(bytes_of_a_key, 160) << "with all digits";
    EXPECT_LT(3600 * 90 * bytes_of_a_key, double(description_size_limit));
    EXPECT_EQ(input_error([&] { description_text(with_keys(100), 1000); }).substr(0, 66),
              "walk.xml: expected paths whose keys a description of 1000 bytes ho");
}

TEST_F(SceneTest, AWrittenDescriptionKeepsItsUnitAndLeadsToItsModel) {
    SceneDescription scene = load(least);
    scene.model_unit_m = 0.01;
    EXPECT_EQ(load(description_text(scene)).model_unit_m, 0.01);
    const std::string text = description_text(scene, description_size_limit, "../model.glb");
    EXPECT_EQ(load_scene(write("elsewhere/scene.json", text)).model, folder_ / "elsewhere/../model.glb");
}

TEST_F(SceneTest, FingerprintFollowsEveryByte) {
    write("walk.csv", "0,1,2,3,1,0,0,0\n");
    const std::string before = load(full).fingerprint;
    EXPECT_EQ(before.size(), 16u);
    EXPECT_EQ(load(full).fingerprint, before);
    EXPECT_NE(load(std::string(full) + "\n").fingerprint, before);
    write("walk.csv", "0,1,2,4,1,0,0,0\n");
    EXPECT_NE(load(full).fingerprint, before);
    write("walk.csv", "0,1,2,3,1,0,0,0\n");
    EXPECT_EQ(load(full).fingerprint, before);
    GltfBuilder other = GltfBuilder::triangle();
    other.buffer[0] = 1;
    write("model.glb", other.glb());
    EXPECT_NE(load(full).fingerprint, before);
}

TEST_F(SceneTest, GeometryFingerprintFollowsWhatDepthComesFromAndNothingElse) {
    write("walk.csv", "0,1,2,3,1,0,0,0\n");
    const std::string before = load(full).geometry_fingerprint;
    EXPECT_EQ(before.size(), 16u);
    std::string dimmer = full;
    dimmer.replace(dimmer.find("[3, 2, 1]"), 9, "[1, 1, 1]");
    EXPECT_EQ(load(dimmer).geometry_fingerprint, before) << "another sun";
    write("walk.csv", "time_s,x,y,z,qw,qx,qy,qz\n0,1,2,3,1,0,0,0\n");
    EXPECT_EQ(load(full).geometry_fingerprint, before) << "the same path, written otherwise";
    write("walk.csv", "0,1,2,4,1,0,0,0\n");
    EXPECT_NE(load(full).geometry_fingerprint, before) << "another path of a moving object";
    write("walk.csv", "0,1,2,3,1,0,0,0\n");
    GltfBuilder other = GltfBuilder::triangle();
    other.buffer[0] = 1;
    write("model.glb", other.glb());
    EXPECT_NE(load(full).geometry_fingerprint, before);
}

TEST_F(SceneTest, FilesThatAModelNamesBelongToItsFingerprints) {
    write("walk.csv", "0,1,2,3,1,0,0,0\n");
    const GltfBuilder builder = GltfBuilder::triangle();
    // A .glb whose second buffer lies in a file; nothing refers to it, which is no concern of a hash.
    std::string glb = builder.glb();
    const std::string own = "\"buffers\":[{\"byteLength\":" + std::to_string(builder.buffer.size()) + "}]";
    const std::string both = own.substr(0, own.size() - 1) + ",{\"byteLength\":4,\"uri\":\"more%20data.bin\"}]";
    ASSERT_NE(glb.find(own), std::string::npos);
    std::uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, 4);
    std::string json = glb.substr(20, length);
    json.replace(json.find(own), own.size(), both);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    glb.replace(20, length, json);
    const auto put_length = [&](std::size_t at, std::size_t value) {
        const auto number = static_cast<std::uint32_t>(value);
        std::memcpy(glb.data() + at, &number, 4);
    };
    put_length(8, glb.size());
    put_length(12, json.size());
    for (const auto& [name, content] : {std::pair{"model.glb", glb}, {"model.gltf", builder.gltf("more%20data.bin")}}) {
        write(name, content);
        std::string text = full;
        text.replace(text.find("model.glb"), 9, name);
        write("more data.bin", "0000");
        const SceneDescription before = load(text);
        EXPECT_EQ(load(text).geometry_fingerprint, before.geometry_fingerprint) << name;
        write("more data.bin", "0001");
        EXPECT_NE(load(text).geometry_fingerprint, before.geometry_fingerprint) << name;
        EXPECT_NE(load(text).fingerprint, before.fingerprint) << name;
    }
}

TEST_F(SceneTest, AFileThatAModelNamesOverAndOverIsReadOnce) {
    write("large.bin", std::string(16 << 20, 'x'));
    GltfBuilder builder = GltfBuilder::triangle();
    Json all = Json::parse(builder.gltf("large.bin"));
    for (int i = 0; i < 50000; ++i)
        all["buffers"].push_back({{"byteLength", 1}, {"uri", i % 2 == 0 ? "large.bin" : "./large.bin"}});
    const std::filesystem::path file = write("model.gltf", all.dump());
    const auto start = Clock::now();
    EXPECT_FALSE(geometry_fingerprint(file, 1, {}).empty());
    EXPECT_LT(seconds_since(start), 20) << "800 GB otherwise";
}

TEST_F(SceneTest, MovingObjectsReplaceRotationAndTranslationAndKeepScale) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["nodes"] = Json::array();
    builder.node({{"name", "train"}, {"mesh", 0}, {"translation", {9, 9, 9}}, {"scale", {2, 2, 2}}, {"children", {1}}});
    builder.node({{"name", "wagon"}, {"mesh", 0}, {"translation", {0, 0, 1}}});
    builder.node({{"name", "house"}, {"mesh", 0}, {"translation", {5, 0, 0}}});
    const SceneModel model = load_model(write("train.glb", builder.glb()));
    SceneDescription scene;
    const glm::dquat quarter = glm::angleAxis(std::acos(0.0), glm::dvec3(0, 1, 0));
    scene.moving = {{"train", PosePath({{0, {{0, 0, 0}, quarter}}, {1, {{10, 0, 0}, quarter}}}, "test")}};
    EXPECT_EQ(find_moving_instances(model, scene), (std::vector<std::uint32_t>{0, 1}));
    const std::vector<glm::mat4> transforms = instance_transforms(model, scene, 0.5);
    ASSERT_EQ(transforms.size(), 3u);
    const auto expect_at = [&](std::size_t instance, glm::vec3 from, glm::vec3 to) {
        EXPECT_NEAR(glm::length(glm::vec3(transforms[instance] * glm::vec4(from, 1)) - to), 0, 1e-5);
    };
    // A quarter turn about y takes x to -z; the scale of 2 stays; the wagon hangs 1 (scaled to 2) along the train's z.
    expect_at(0, {1, 0, 0}, {5, 0, -2});
    expect_at(0, {0, 1, 0}, {5, 2, 0});
    expect_at(1, {0, 0, 0}, {7, 0, 0});
    expect_at(2, {0, 0, 0}, {5, 0, 0});
    SceneModel flat = model;
    flat.instances[1].world_from_object[1] = glm::vec4(0);
    const std::string refusal = input_error([&] { find_moving_instances(flat, scene); });
    expect_contains(refusal, "expected nodes of some volume below \"train\", which moves, found \"wagon\"");
    EXPECT_EQ(input_error([&] { instance_transforms(flat, scene, 0); }), refusal);
    scene.moving[0].object = "ship";
    expect_contains(input_error([&] { instance_transforms(model, scene, 0); }), "\"ship\"");
}

}  // namespace equistream::test
