#include "scene.h"

#include <equistream/error.h>
#include <equistream/json_text.h>

#include <nlohmann/json.hpp>

namespace equistream {
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

std::string moving_text(const std::vector<MovingObject>& moving) {
    std::string text;
    for (const MovingObject& object : moving)
        text += (text.empty() ? "" : ",\n") + std::string("    {\"object\": ") + exact(object.object) +
                ", \"keys\": [\n" + key_lines(object.path, "      ") + "\n    ]}";
    return text;
}

}  // namespace

std::string description_text(const SceneDescription& description) {
    const std::string model =
        description.model.empty() ? description.name + ".glb" : description.model.filename().string();
    std::string text = "{\n  \"name\": " + json_text(Json(description.name)) + ",\n  \"model\": " + exact(model);
    const auto add = [&](const std::string& key, const Json& value) {
        text += ",\n  \"" + key + "\": " + json_text(value);
    };
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
    return text + "\n}\n";
}

}  // namespace equistream
