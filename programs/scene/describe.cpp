#include "describe.h"

#include "summary.h"
#include "viewpoint.h"

#include <equistream/error.h>
#include <equistream/file_kind.h>
#include <equistream/json_text.h>
#include <equistream/sequence.h>
#include <equistream/text.h>
#include <programs/cli/paths.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>
#include <scenes/generate/generate.h>
#include <scenes/library/file_bytes.h>
#include <scenes/library/obj_files.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

namespace equistream {
namespace {

namespace fs = std::filesystem;

constexpr double default_head_radius_m = 0.1;

/// The size of a block of houses: an OBJ that would be larger is taken to be in a smaller unit.
constexpr double max_guessed_size_m = 200;

struct Unit {
    double metres = 1;
    std::string reason;
};

struct Described {
    SceneDescription scene;
    Unit unit;
    WorldBox bounds;
    Viewpoint viewpoint;
    std::uint64_t emissive_triangles = 0;
    std::vector<std::string> notes;
};

fs::path folder_of(const fs::path& file) {
    return file.has_parent_path() ? file.parent_path() : ".";
}

void require_model(const fs::path& file) {
    const FileKind kind = file_kind(file);
    if (kind != FileKind::model && kind != FileKind::unknown)
        throw InputError(
            expected_found(file.string(), "a model (.glb, .gltf or .obj)", found_kind(file, "another file")));
}

Unit unit_of(const DescribeArguments& arguments, const glm::dvec3& size) {
    if (arguments.unit_m)
        return {*arguments.unit_m, "--unit"};
    if (!is_obj(arguments.model))
        return {1, "glTF's"};
    const double largest = std::max({size.x, size.y, size.z});
    const auto fits = [&](double metres) { return metres * largest <= max_guessed_size_m; };
    return {fits(1) ? 1 : fits(0.01) ? 0.01 : 0.001, "a guess by its size; --unit sets another"};
}

Pose to_the_millimetre(Pose pose) {
    pose.position_m = glm::round(1000.0 * pose.position_m) / 1000.0 + 0.0;  // which makes 0 of -0
    return pose;
}

Described described(const DescribeArguments& arguments, const fs::path& out) {
    SceneModel model = load_model(arguments.model);
    const WorldBox in_units = bounds_of(model, instance_transforms(model, SceneDescription{}, 0));
    Described d;
    d.unit = unit_of(arguments, in_units.high - in_units.low);
    scale_model(model, d.unit.metres);
    d.bounds = {d.unit.metres * in_units.low, d.unit.metres * in_units.high};
    d.viewpoint = find_viewpoint(model, d.bounds);
    d.viewpoint.pose = to_the_millimetre(d.viewpoint.pose);
    d.emissive_triangles = emissive_triangles(model);
    d.notes = std::move(model.notes);
    d.scene.file = out;
    d.scene.name = scene_name_of(out);
    d.scene.model = arguments.model;
    d.scene.model_unit_m = d.unit.metres;
    d.scene.camera_path = PosePath({{0, d.viewpoint.pose}}, out.string());
    d.scene.head_radius_m = default_head_radius_m;
    // From outside, what glows in a model hardly lights it.
    if (d.emissive_triangles == 0 || !d.viewpoint.is_inside)
        add_daylight(d.scene);
    else if (!d.viewpoint.is_closed)
        d.notes.push_back(out.string() + ": no sun and no sky, as the model has lights of its own");
    if (d.emissive_triangles == 0 && d.viewpoint.is_closed)
        d.notes.push_back(out.string() + ": frames may be black: the room is closed, and no material emits light");
    return d;
}

/// The way to the model from where the description will lie.
fs::path model_from(const fs::path& out, const fs::path& model) {
    std::error_code error;
    const fs::path way = fs::proximate(folder_of(model), folder_of(out), error);
    if (error)
        throw InputError(expected_found("--out " + out.string(), "a path from which the model's folder can be reached",
                                        error.message()));
    return (way / model.filename()).lexically_normal();
}

/// The same text and, if asked for, another description make way; nothing else does.
void require_replaceable(const fs::path& file, const std::string& text, bool overwrite) {
    std::error_code error;
    if (!fs::exists(file, error))
        return;
    std::ostringstream there;
    there << open_regular_file(file, "scene description (JSON)").rdbuf();
    const std::string found = there.str();
    if (found == text)
        return;
    const auto json = nlohmann::json::parse(found, nullptr, false);
    const bool is_description = json.is_object() && json.contains("model") && json.contains("camera");
    cli::require(is_description, "--out " + file.string(), "a new name, or a scene description to replace",
                 "another file");
    cli::require(overwrite, "--out " + file.string(), "a new name, or --overwrite", "another scene description");
}

std::string position_text(const glm::dvec3& p) {
    return formatted("(%g, %g, %g)", p.x, p.y, p.z);
}

std::string text_of(const Described& d) {
    const glm::dvec3 size = d.bounds.high - d.bounds.low;
    const Viewpoint& v = d.viewpoint;
    std::string text = d.scene.file.string() + ": describes " + d.scene.model.string() +
                       formatted(", %.1f x %.1f x %.1f m\n", size.x, size.y, size.z);
    text += formatted("unit      %g m (%s)\n", d.unit.metres, d.unit.reason.c_str());
    text += std::string("up        +Y ") + (is_obj(d.scene.model) ? "(a guess: an OBJ does not say)\n" : "(glTF's)\n");
    text += "camera    " + std::string(v.is_inside ? "inside" : "outside, in front of the model") + ", at " +
            position_text(v.pose.position_m) + "\n";
    text += "lights    " + std::string(d.scene.sun ? "sun and sky" : "the model's own") +
            formatted(", %llu emissive triangles\n", static_cast<unsigned long long>(d.emissive_triangles));
    return text;
}

nlohmann::ordered_json json_of(const Described& d, const std::string& command) {
    const glm::dvec3 &at = d.viewpoint.pose.position_m, &low = d.bounds.low, &high = d.bounds.high;
    nlohmann::ordered_json json = cli::provenance(command);
    json["scene"] = d.scene.file.string();
    json["model"] = d.scene.model.string();
    json["model_unit_m"] = d.unit.metres;
    json["unit_from"] = d.unit.reason;
    json["bounding_box_m"] = {{low.x, low.y, low.z}, {high.x, high.y, high.z}};
    json["inside"] = d.viewpoint.is_inside;
    json["position_m"] = {at.x, at.y, at.z};
    json["sun"] = d.scene.sun.has_value();
    json["emissive_triangles"] = d.emissive_triangles;
    json["notes"] = d.notes;
    return json;
}

}  // namespace

cli::CommandLine add_describe_command(cli::CommandLine& app, DescribeArguments& arguments) {
    cli::CommandLine command =
        app.add_subcommand("describe", "write a scene description for a model; its camera stands 1.6 m above a floor "
                                       "and far from all surfaces, or in front of a model without an inside");
    command.footer("Example:\n  equistream scene describe room.glb --out room.json");
    command.add_option("MODEL", arguments.model, "model (.glb, .gltf or .obj)").required();
    command.add_option("--out", arguments.out, "description to write, NAME.json; beside the model unless given");
    command
        .add_option(
            "--unit", arguments.unit_m,
            "metres that one unit of the model stands for; unless given, 1 for glTF, and for an OBJ the first of "
            "1, 0.01 and 0.001 that makes it at most 200 m across")
        .between(1e-6, 1e6);
    command.add_flag("--overwrite", arguments.overwrite, "replace another scene description");
    cli::add_json_flag(command, arguments.json);
    return command;
}

void describe(const DescribeArguments& arguments) {
    require_model(arguments.model);
    const fs::path out = arguments.out.empty() ? fs::path(arguments.model).replace_extension(".json") : arguments.out;
    cli::require(out.extension() == ".json", "--out", "a name that ends in .json", "'" + out.string() + "'");
    cli::require_writable_file(out);
    const Described d = described(arguments, out);
    const std::string text = description_text(d.scene, description_size_limit, model_from(out, arguments.model));
    require_replaceable(out, text, arguments.overwrite);
    write_file_atomically(out, text);
    if (arguments.json) {
        std::puts(json_text(json_of(d, arguments.command), 2).c_str());
        return;
    }
    for (const std::string& note : d.notes)
        std::fprintf(stderr, "equistream scene: %s\n", note.c_str());
    std::fputs(text_of(d).c_str(), stdout);
}

}  // namespace equistream
