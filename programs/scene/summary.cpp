#include "summary.h"

#include <equistream/bound.h>
#include <equistream/camera.h>
#include <equistream/json_text.h>
#include <equistream/text.h>

#include <scenes/library/polygon.h>

#include <glm/gtc/type_ptr.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

namespace equistream {
namespace {

std::vector<WorldBox> mesh_boxes(const SceneModel& model) {
    std::vector<WorldBox> boxes(model.meshes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i)
        for (const glm::vec3& p : model.meshes[i].positions)
            boxes[i].add(p);
    return boxes;
}

WorldBox transformed(const WorldBox& box, const glm::mat4& world_from_object) {
    WorldBox result;
    for (int corner = 0; corner < 8; ++corner)
        result.add(glm::dmat4(world_from_object) * glm::dvec4(corner & 1 ? box.high.x : box.low.x,
                                                              corner & 2 ? box.high.y : box.low.y,
                                                              corner & 4 ? box.high.z : box.low.z, 1));
    return result;
}

/// Instances in order of their boxes' distance, until no box can hold anything nearer.
double nearest_triangle(const SceneModel& model, const std::vector<WorldBox>& boxes,
                        const std::vector<glm::mat4>& world, const glm::dvec3& from) {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < model.instances.size(); ++i)
        order.emplace_back(transformed(boxes[model.instances[i].mesh], world[i]).distance(from), i);
    std::sort(order.begin(), order.end());
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [box_distance, i] : order) {
        if (box_distance >= nearest)
            break;
        const Mesh& mesh = model.meshes[model.instances[i].mesh];
        const glm::dmat4 transform(world[i]);
        const auto at = [&](unsigned index) {
            return glm::dvec3(transform * glm::dvec4(glm::dvec3(mesh.positions[index]), 1));
        };
        for (const glm::uvec3& t : mesh.triangles)
            nearest = std::min(nearest, distance_to_triangle(from, at(t.x), at(t.y), at(t.z)));
    }
    return nearest;
}

void measure_path(const SceneModel& model, const SceneDescription& scene, SceneSummary& out) {
    std::vector<PosePath::Key> keys;  // from 0 on, where frames begin
    if (!scene.camera_path.keys().empty())
        keys.push_back({0, scene.camera_path.at(0)});
    std::ranges::copy_if(scene.camera_path.keys(), std::back_inserter(keys),
                         [](const PosePath::Key& key) { return key.time_s > 0; });
    for (std::size_t i = 1; i < keys.size(); ++i) {
        out.path_length_m += glm::length(keys[i].pose.position_m - keys[i - 1].pose.position_m);
        const glm::dvec3 a = keys[i - 1].pose.orientation * glm::dvec3(0, 0, -1);
        const glm::dvec3 b = keys[i].pose.orientation * glm::dvec3(0, 0, -1);
        const double turn_deg = glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
        out.turn_deg += turn_deg;
        if (const double step_s = keys[i].time_s - keys[i - 1].time_s; step_s > 0)
            out.fastest_turn_deg_s = std::max(out.fastest_turn_deg_s, turn_deg / step_s);
    }
    out.path_duration_s = scene.camera_path.duration_s();
    const std::vector<WorldBox> boxes = mesh_boxes(model);
    const int samples = out.path_duration_s > 0 ? 31 : 1;
    out.nearest_m = std::numeric_limits<double>::infinity();
    for (int i = 0; i < samples; ++i) {
        const double time_s = samples > 1 ? out.path_duration_s * i / (samples - 1) : 0;
        const double distance = nearest_triangle(model, boxes, instance_transforms(model, scene, time_s),
                                                 scene.camera_path.at(time_s).position_m);
        if (distance < out.nearest_m) {
            out.nearest_m = distance;
            out.nearest_time_s = time_s;
        }
    }
}

std::string line(const char* what, const std::string& value) {
    std::string text(what);
    text.resize(20, ' ');
    return text + value + "\n";
}

nlohmann::ordered_json finite_or_null(double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace

WorldBox bounds_of(const SceneModel& model, std::span<const glm::mat4> world_from_object) {
    WorldBox box;
    for (std::size_t i = 0; i < model.instances.size(); ++i) {
        const Mesh& mesh = model.meshes[model.instances[i].mesh];
        const glm::dmat4 transform(world_from_object[i]);
        for (const glm::uvec3& t : mesh.triangles)
            for (const unsigned index : {t.x, t.y, t.z})
                box.add(transform * glm::dvec4(glm::dvec3(mesh.positions[index]), 1));
    }
    return box;
}

std::uint64_t emissive_triangles(const SceneModel& model) {
    std::uint64_t count = 0;
    for (const Instance& instance : model.instances) {
        const Mesh& mesh = model.meshes[instance.mesh];
        const std::size_t material = mesh.material == no_index ? model.materials.size() - 1 : mesh.material;
        if (model.materials[material].emission != glm::vec3(0))
            count += mesh.triangles.size();
    }
    return count;
}

SceneSummary summarise(const SceneModel& model, const SceneDescription& scene) {
    SceneSummary out;
    out.name = scene.name;
    out.triangles = model.triangle_count();
    out.unique_triangles = model.unique_triangle_count();
    out.meshes = model.meshes.size();
    out.instances = model.instances.size();
    out.objects = model.objects.size();
    out.materials = model.materials.size();
    out.textures = model.textures.size();
    for (const Texture& texture : model.textures)
        out.texture_bytes += texture.encoded.size();
    for (const Material& material : model.materials)
        out.masked_materials += material.alpha_mask != no_index;
    out.has_sun = scene.sun.has_value();
    out.has_sky = scene.sky_image || scene.sky_radiance != glm::dvec3(0);
    if (scene.sky_image)
        out.sky_image = scene.sky_image->file.string();
    out.moving_objects = scene.moving.size();
    out.emissive_triangles = emissive_triangles(model);
    const WorldBox bounds = bounds_of(model, instance_transforms(model, scene, 0));
    out.box_low_m = bounds.low;
    out.box_high_m = bounds.high;
    measure_path(model, scene, out);
    out.head_radius_m = scene.head_radius_m;
    out.box_radius_m = head_box_radius_centre(scene.head_radius_m, default_ipd_m);
    out.sphere_width = matching_sphere_width(default_focal_length_px);
    const double margin_deg = 2 * out.fastest_turn_deg_s * window_delay_s;
    // The gaze may be an eighth of each side from the middle before a window follows it (window.h).
    const double with_slack = 1 / 0.75;
    out.window_width_deg = std::min(with_slack * (90 + margin_deg), 359.0);
    out.window_height_deg = std::min(with_slack * (2 * glm::degrees(std::atan(9.0 / 16)) + margin_deg), 180.0);
    const double w = bounded_inverse_depth(out.nearest_m, out.box_radius_m);
    out.depth_levels = std::ceil(w / (2 * error_budget_rad(default_focal_length_px)));
    return out;
}

std::string summary_text(const SceneSummary& s) {
    std::string text;
    text += line("scene", s.name);
    text += line("triangles", formatted("%llu (%llu unique)", static_cast<unsigned long long>(s.triangles),
                                        static_cast<unsigned long long>(s.unique_triangles)));
    text += line("instances", formatted("%zu of %zu meshes, %zu nodes", s.instances, s.meshes, s.objects));
    text += line("materials", formatted("%zu (%zu alpha-masked)", s.materials, s.masked_materials));
    text +=
        line("textures", formatted("%zu, %.2f MB encoded", s.textures, 1e-6 * static_cast<double>(s.texture_bytes)));
    text +=
        line("lights", formatted("%s, %s, %llu emissive triangles", s.has_sun ? "sun" : "no sun",
                                 s.has_sky ? "sky" : "no sky", static_cast<unsigned long long>(s.emissive_triangles)));
    if (!s.sky_image.empty())
        text += line("sky image", s.sky_image);
    text += line("moving objects", std::to_string(s.moving_objects));
    text += line("bounding box", formatted("(%.4g, %.4g, %.4g) to (%.4g, %.4g, %.4g) m", s.box_low_m.x, s.box_low_m.y,
                                           s.box_low_m.z, s.box_high_m.x, s.box_high_m.y, s.box_high_m.z));
    text += line("camera path",
                 formatted("%.2f m in %.2f s, turning %.0f degrees", s.path_length_m, s.path_duration_s, s.turn_deg));
    text += line("nearest triangle", formatted("%.3f m, at %.2f s", s.nearest_m, s.nearest_time_s));
    text += line("head box", formatted("lean %.3f m; with a %.0f mm IPD, B = %.4f m", s.head_radius_m,
                                       1000 * default_ipd_m, s.box_radius_m));
    text += line("matching sphere", formatted("%.0f columns for f = %.0f px", s.sphere_width, default_focal_length_px));
    text += line("matching window",
                 formatted("%.0fx%.0f degrees for a 90 degree view of 16:9 that is %.2f s late at up to %.0f degrees/s",
                           s.window_width_deg, s.window_height_deg, window_delay_s, s.fastest_turn_deg_s));
    text += line("depth codes", std::isfinite(s.depth_levels)
                                    ? formatted("%.0f levels for a quarter pixel", s.depth_levels)
                                    : std::string("none suffice: the head box touches the nearest triangle"));
    return text;
}

nlohmann::ordered_json summary_json(const SceneSummary& s) {
    const auto vector = [](const glm::dvec3& v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
    nlohmann::ordered_json json;
    json["scene"] = s.name;
    json["triangles"] = s.triangles;
    json["unique_triangles"] = s.unique_triangles;
    json["meshes"] = s.meshes;
    json["instances"] = s.instances;
    json["objects"] = s.objects;
    json["materials"] = s.materials;
    json["masked_materials"] = s.masked_materials;
    json["textures"] = s.textures;
    json["texture_bytes"] = s.texture_bytes;
    json["sun"] = s.has_sun;
    json["sky"] = s.has_sky;
    json["sky_image"] = s.sky_image.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(s.sky_image);
    json["emissive_triangles"] = s.emissive_triangles;
    json["moving_objects"] = s.moving_objects;
    json["bounding_box_m"] = {vector(s.box_low_m), vector(s.box_high_m)};
    json["path_length_m"] = s.path_length_m;
    json["path_duration_s"] = s.path_duration_s;
    json["turn_deg"] = s.turn_deg;
    json["fastest_turn_deg_s"] = s.fastest_turn_deg_s;
    json["nearest_m"] = s.nearest_m;
    json["nearest_time_s"] = s.nearest_time_s;
    json["lean_m"] = s.head_radius_m;
    json["box_radius_m"] = s.box_radius_m;
    json["sphere_width"] = s.sphere_width;
    json["window_deg"] = {s.window_width_deg, s.window_height_deg};
    json["depth_levels"] = finite_or_null(s.depth_levels);
    return json;
}

namespace {

std::array<float, 16> numbers(const glm::mat4& matrix) {
    std::array<float, 16> result{};
    std::copy_n(glm::value_ptr(matrix), result.size(), result.begin());
    return result;
}

}  // namespace

std::string placements_json(const SceneModel& model) {
    nlohmann::json json = {{"objects", nlohmann::json::array()},
                           {"instances", nlohmann::json::array()},
                           {"materials", nlohmann::json::array()}};
    for (const Material& material : model.materials)
        json["materials"].push_back(material.name);
    for (const Object& object : model.objects)
        json["objects"].push_back({{"name", object.name},
                                   {"parent", object.parent},
                                   {"world_from_object", numbers(object.world_from_object)}});
    // A mesh without a material has the last one.
    const auto last = static_cast<std::uint32_t>(model.materials.size() - 1);
    for (const Instance& instance : model.instances)
        json["instances"].push_back({{"object", instance.object},
                                     {"material", std::min(model.meshes[instance.mesh].material, last)},
                                     {"world_from_object", numbers(instance.world_from_object)}});
    // Names come from files and need not be UTF-8.
    return json_text(json) + "\n";
}

}  // namespace equistream
