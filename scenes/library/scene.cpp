#include "scene.h"

#include "description_json.h"
#include "file_bytes.h"

#include <equistream/camera_limits.h>
#include <equistream/conventions.h>
#include <equistream/error.h>
#include <equistream/file_kind.h>
#include <equistream/frame.h>
#include <equistream/json_text.h>

#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdlib>
#include <unordered_set>

namespace equistream {

namespace fs = std::filesystem;

namespace {

constexpr double darkest_exposure = 1e-12, brightest_exposure = 1e12;

double radians(double degrees) {
    return degrees * pi / 180;
}

Sun read_sun(const JsonReader& json) {
    json.accept_keys({"azimuth_deg", "elevation_deg", "towards", "irradiance", "angular_radius_deg"});
    Sun sun;
    if (json.has("towards")) {
        if (json.has("azimuth_deg") || json.has("elevation_deg"))
            json.fail("either towards, or azimuth_deg and elevation_deg,");
        sun.towards = json["towards"].vector3();
        const double length = glm::length(sun.towards);
        if (!std::isfinite(length) || !(length > 0))
            json["towards"].fail("a direction, not a vector without length,");
        sun.towards /= length;
    } else {
        const double azimuth = json["azimuth_deg"].number();
        const double elevation = json["elevation_deg"].number();
        if (!(std::abs(elevation) <= 90))
            json["elevation_deg"].fail("a number from -90 to 90");
        const auto d = direction_from_longitude_latitude(radians(azimuth), radians(elevation));
        sun.towards = {d.x, d.y, d.z};
    }
    sun.irradiance = json["irradiance"].colour();
    if (json.has("angular_radius_deg")) {
        const double radius = json["angular_radius_deg"].number_above(0);
        if (radius > 90)
            json["angular_radius_deg"].fail("a number of at most 90");
        sun.angular_radius_rad = radians(radius);
    }
    return sun;
}

glm::dquat looking_along(const glm::dvec3& direction, const JsonReader& json) {
    const double length = glm::length(direction);
    const double sideways = std::hypot(direction.x, direction.z);
    if (!std::isfinite(length) || !(sideways > 1e-6 * length))
        json.fail("a point that is not straight above, below or at position_m");
    return glm::quatLookAtRH(direction / length, glm::dvec3(0, 1, 0));
}

PosePath::Key read_key(const JsonReader& json) {
    json.accept_keys({"time_s", "position_m", "look_at_m", "orientation_wxyz"});
    PosePath::Key key;
    key.time_s = json["time_s"].number();
    key.pose.position_m = json["position_m"].vector3();
    if (!is_position(key.pose.position_m))
        json["position_m"].fail("coordinates from -1e9 to 1e9 metres");
    if (json.has("look_at_m") && json.has("orientation_wxyz"))
        json.fail("either look_at_m or orientation_wxyz");
    if (json.has("look_at_m"))
        key.pose.orientation = looking_along(json["look_at_m"].vector3() - key.pose.position_m, json["look_at_m"]);
    if (json.has("orientation_wxyz")) {
        const std::vector<double> q = json["orientation_wxyz"].numbers(4);
        key.pose.orientation = glm::dquat(q[0], q[1], q[2], q[3]);
        if (!(std::abs(glm::length(key.pose.orientation) - 1) < 0.01))
            json["orientation_wxyz"].fail("a unit quaternion");
    }
    return key;
}

/// What "camera" and each of "moving" share: inline keys, or a CSV file whose bytes join the fingerprint. Where
/// both have another clock than frames, both count from `clock_start_s`, the camera's first key.
PosePath read_path(const JsonReader& json, const fs::path& folder, ContentHash& hash, double clock_start_s = 0) {
    if (json.has("keys") == json.has("path"))
        json.fail("one of keys and path");
    if (json.has("path")) {
        const fs::path csv = folder / json["path"].text();
        PosePath path = read_path_csv(csv, clock_start_s);
        hash.add_file(csv, "camera path (CSV)");
        return path;
    }
    std::vector<PosePath::Key> keys;
    for (const JsonReader& item : json["keys"].array()) {
        keys.push_back(read_key(item));
        if (keys.size() > 1 && !(keys.back().time_s > keys[keys.size() - 2].time_s))
            item["time_s"].fail("a time after the key before,");
    }
    if (keys.empty())
        json["keys"].fail("at least one key");
    return PosePath::on_frame_clock(std::move(keys), json["keys"].where(), clock_start_s);
}

/// A large file that a description shares with others: the model, the sky's image.
fs::path find_file(const JsonReader& json, const fs::path& folder, const std::string& what) {
    const fs::path name = json.text();
    std::vector<fs::path> places{folder / name};
    const char* scenes = std::getenv("EQUISTREAM_SCENES");
    if (scenes && *scenes && name.is_relative()) {
        places.push_back(fs::path(scenes) / name);
        places.push_back(fs::path(scenes) / name.stem() / name);
    }
    std::string tried;
    std::error_code error;
    for (const fs::path& place : places) {
        if (fs::is_regular_file(place, error))
            return place;
        tried += (tried.empty() ? "" : ", ") + place.string();
    }
    if (!scenes || !*scenes)
        tried += " (EQUISTREAM_SCENES is not set)";
    throw InputError(expected_found(json.where(), "the " + what + " at one of " + tried, "none"));
}

SkyImage read_sky_image(const JsonReader& json, const fs::path& folder, ContentHash& hash) {
    SkyImage sky;
    sky.file = find_file(json["image"], folder, "image");
    hash.add_file(sky.file, "sky image");
    if (json.has("rotation_deg"))
        sky.rotation_rad = radians(json["rotation_deg"].number());
    if (json.has("scale"))
        sky.scale = json["scale"].colour();
    return sky;
}

void read_sky(const JsonReader& json, const fs::path& folder, ContentHash& hash, SceneDescription& scene) {
    json.accept_keys({"radiance", "image", "rotation_deg", "scale"});
    if (json.has("radiance") == json.has("image"))
        json.fail("one of radiance and image");
    if (json.has("image")) {
        scene.sky_image = read_sky_image(json, folder, hash);
        return;
    }
    for (const char* key : {"rotation_deg", "scale"})
        if (json.has(key))
            json[key].fail("an image to go with it");
    scene.sky_radiance = json["radiance"].colour();
}

double read_unit(const JsonReader& json) {
    const double unit_m = json.number();
    if (!(unit_m >= 1e-6 && unit_m <= 1e6))
        json.fail("a number from 1e-6 to 1e6");
    return unit_m;
}

double read_frames_per_second(const JsonReader& json) {
    const double rate = json.number_above(0);
    if (rate > 1000)
        json.fail("a number of at most 1000");
    return rate;
}

std::string read_fingerprint(const JsonReader& json) {
    std::string text = json.text();
    if (text.size() != 16 || text.find_first_not_of("0123456789abcdef") != std::string::npos)
        json.fail("16 hexadecimal digits");
    return text;
}

std::string read_name(const JsonReader& json, const fs::path& file) {
    if (!json.has("name"))
        return scene_name_of(file);
    std::string name = json["name"].text();
    if (name.size() > max_name_bytes)
        json["name"].fail("at most 255 bytes");
    return name;
}

std::vector<MovingObject> read_moving(const JsonReader& json, const fs::path& folder, double clock_start_s,
                                      ContentHash& hash) {
    std::vector<MovingObject> moving;
    std::unordered_set<std::string> names;
    for (const JsonReader& item : json.array()) {
        item.accept_keys({"object", "keys", "path"});
        MovingObject object;
        object.object = item["object"].text();
        object.path = read_path(item, folder, hash, clock_start_s);
        if (!names.insert(object.object).second)
            item["object"].fail("each object once");
        moving.push_back(std::move(object));
    }
    return moving;
}

/// A file of another kind is refused by what it is rather than by its first byte that is not JSON.
void require_description(const fs::path& file) {
    const FileKind kind = file_kind(file);
    if (kind == FileKind::unknown || kind == FileKind::description || kind == FileKind::folder)
        return;
    const fs::path beside = fs::path(file).replace_extension(".json");
    std::error_code error;
    throw InputError(expected_found(file.string(), "a scene description (JSON)",
                                    kind == FileKind::model && fs::is_regular_file(beside, error)
                                        ? "a model (" + beside.string() + " beside it describes it)"
                                        : found_kind(file, "another file")));
}

}  // namespace

std::string scene_name_of(const fs::path& file) {
    return as_json_holds(file.stem().string(), max_name_bytes);
}

SceneDescription load_scene(const fs::path& file) {
    require_description(file);
    const std::vector<std::uint8_t> bytes = read_file_bytes(file, "scene description (JSON)", description_size_limit);
    const std::string file_name = file.string();
    const JsonValue tree = parse_json({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file_name);
    const JsonReader json(tree, file_name, "");
    json.accept_keys({"name", "model", "model_unit_m", "sun", "sky", "camera", "head_box", "exposure",
                      "frames_per_second", "moving", "stands_for"});

    ContentHash hash;
    hash.add(bytes);
    const fs::path folder = file.parent_path();
    SceneDescription scene;
    scene.file = file;
    scene.name = read_name(json, file);
    if (json.has("sun"))
        scene.sun = read_sun(json["sun"]);
    if (json.has("sky"))
        read_sky(json["sky"], folder, hash, scene);
    json["camera"].accept_keys({"keys", "path"});
    scene.camera_path = read_path(json["camera"], folder, hash);
    if (json.has("head_box")) {
        json["head_box"].accept_keys({"lean_m"});
        scene.head_radius_m = json["head_box"]["lean_m"].number_within(0, max_head_box_radius_m);
    }
    if (json.has("exposure"))
        scene.exposure = json["exposure"].number_within(darkest_exposure, brightest_exposure);
    if (json.has("frames_per_second"))
        scene.frames_per_second = read_frames_per_second(json["frames_per_second"]);
    if (json.has("moving"))
        scene.moving = read_moving(json["moving"], folder, scene.camera_path.clock_start_s(), hash);
    scene.model = find_file(json["model"], folder, "model");
    if (json.has("model_unit_m"))
        scene.model_unit_m = read_unit(json["model_unit_m"]);
    if (json.has("stands_for"))
        scene.stands_for = read_fingerprint(json["stands_for"]);
    scene.geometry_fingerprint = geometry_fingerprint(scene.model, scene.model_unit_m, scene.moving);
    hash.add(scene.geometry_fingerprint);
    scene.fingerprint = hash.hex();
    return scene;
}

namespace {

using Json = nlohmann::ordered_json;

Json vector3(const glm::dvec3& v) {
    return Json::array({v.x, v.y, v.z});
}

/// As a JSON string that reads back as the same bytes.
std::string exact(const std::string& name) {
    if (!is_utf8(name))
        throw InputError(expected_found(name, "a name in UTF-8, as a scene's JSON needs", "other bytes"));
    return json_text(Json(name));
}

/// One key a line, so that a path can be read and edited.
std::string key_lines(const PosePath& path, const std::string& indent) {
    std::string text;
    for (const PosePath::Key& key : path.keys()) {
        const glm::dquat& q = key.pose.orientation;
        Json json;
        json["time_s"] = key.time_s;
        json["position_m"] = vector3(key.pose.position_m);
        json["orientation_wxyz"] = Json::array({q.w, q.x, q.y, q.z});
        text += (text.empty() ? "" : ",\n") + indent + json_text(json);
    }
    return text;
}

/// Times of a path that ends before 0 would be taken for those of another clock (PosePath::on_frame_clock).
PosePath until_the_start(const PosePath& path) {
    std::vector<PosePath::Key> keys = path.keys();
    if (!keys.empty() && keys.back().time_s < 0)
        keys.push_back({0, keys.back().pose});
    return PosePath(std::move(keys), "moving");
}

std::string moving_text(const std::vector<MovingObject>& moving) {
    std::string text;
    for (const MovingObject& object : moving)
        text += (text.empty() ? "" : ",\n") + std::string("    {\"object\": ") + exact(object.object) +
                ", \"keys\": [\n" + key_lines(until_the_start(object.path), "      ") + "\n    ]}";
    return text;
}

}  // namespace

std::string description_text(const SceneDescription& description, std::uint64_t limit_bytes,
                             const fs::path& model_from_it) {
    const std::string model = !model_from_it.empty()      ? model_from_it.string()
                              : description.model.empty() ? description.name + ".glb"
                                                          : description.model.filename().string();
    std::string text = "{\n  \"name\": " + json_text(Json(description.name)) + ",\n  \"model\": " + exact(model);
    const auto add = [&](const std::string& key, const Json& value) {
        text += ",\n  \"" + key + "\": " + json_text(value);
    };
    if (description.model_unit_m != 1)
        add("model_unit_m", description.model_unit_m);
    if (description.sun)
        add("sun", {{"towards", vector3(description.sun->towards)},
                    {"irradiance", vector3(description.sun->irradiance)},
                    {"angular_radius_deg", glm::degrees(description.sun->angular_radius_rad)}});
    if (description.sky_radiance != glm::dvec3(0))
        add("sky", {{"radiance", vector3(description.sky_radiance)}});
    text += ",\n  \"camera\": {\"keys\": [\n" + key_lines(description.camera_path, "    ") + "\n  ]}";
    if (description.head_radius_m > 0)
        add("head_box", {{"lean_m", description.head_radius_m}});
    add("exposure", description.exposure);
    add("frames_per_second", description.frames_per_second);
    if (!description.moving.empty())
        text += ",\n  \"moving\": [\n" + moving_text(description.moving) + "\n  ]";
    if (!description.stands_for.empty())
        add("stands_for", description.stands_for);
    text += "\n}\n";
    if (text.size() > limit_bytes)
        throw InputError(expected_found(description.file.string(),
                                        "paths whose keys a description of " + std::to_string(limit_bytes) +
                                            " bytes holds (fewer keys a second)",
                                        std::to_string(text.size()) + " bytes of them"));
    return text;
}

}  // namespace equistream
