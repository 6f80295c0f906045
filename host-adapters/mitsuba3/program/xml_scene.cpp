#include "xml_scene.h"

#include "child_process.h"
#include "geometry_model.h"

#include <equistream/bound.h>
#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream/sequence.h>
#include <scenes/library/write_glb.h>

#include <nlohmann/json.hpp>

#include <unistd.h>

#include <cstdio>

namespace equistream::mitsuba_host {

namespace fs = std::filesystem;

namespace {

std::string parameters_text(const HostOptions& host) {
    std::string text = "sensor " + std::to_string(host.sensor) + " up " + host.up + " unit " + in_words(host.unit_m);
    for (const std::string& definition : host.definitions)
        text += "\n" + definition;
    return text;
}

/// Mitsuba stops at the first thing that it does not know: of a scene for Mitsuba 0.6 all are said.
std::unique_ptr<EmbeddedScene> load(const Engine& engine, const SceneRequest& request) {
    try {
        return EmbeddedScene::load(engine, request);
    } catch (const InputError& problem) {
        std::vector<std::string> changes;
        try {
            const std::string answer = run_beside("equistream-scene", {"info", request.xml.string(), "--json"});
            changes = nlohmann::json::parse(answer).at("must_change").get<std::vector<std::string>>();
        } catch (const std::exception&) {  // what Mitsuba says is all there is
        }
        if (changes.empty())
            throw;
        for (const std::string& change : changes)
            std::fprintf(stderr, "equistream render: note: %s\n", change.c_str());
        throw InputError(std::string(problem.what()) + "; for Mitsuba 3 " + std::to_string(changes.size()) +
                         " things must change, listed above");
    }
}

constexpr const char* model_name = "scene.glb";
constexpr const char* description_name = "scene.json";

}  // namespace

XmlScene::XmlScene(const LoadContext& context) : out_(context.options.out), ipd_m_(context.options.ipd_m) {
    SceneRequest request;
    request.xml = context.options.scene;
    request.parameters = context.host.parameters();
    request.sensor = context.host.sensor;
    request.aovs = context.aovs;
    request.sensors = context.sensors;
    if (context.host.max_bounces)
        request.max_depth = static_cast<int>(*context.host.max_bounces) + 1;
    scene_ = load(context.engine, request);
    const XmlSensor& sensor = scene_->xml_sensor();
    const std::string up = context.host.up == "auto" ? nearest_up(sensor.to_world) : context.host.up;
    if (context.host.up == "auto" && up != "y")
        std::fprintf(stderr, "equistream render: note: the sensor's up is nearest to the XML's %s, which becomes +Y\n",
                     (up.size() > 1 ? up : "+" + up).c_str());
    world_ = WorldMap::with_up(up, context.host.unit_m);
    description_.file = request.xml;
    description_.name = request.xml.stem().string().substr(0, 255);
    description_.head_radius_m = context.host.head_radius_m;
    description_.camera_path = PosePath({{0, world_.pose(sensor.to_world)}}, request.xml.string());
    if (sensor.count == 0 && context.options.path.empty())
        std::fprintf(stderr, "equistream render: note: the XML has no sensor; the head stands at its origin\n");
    description_.fingerprint = content_fingerprint(sensor.files, parameters_text(context.host) + "\n" + sensor.spectra);
}

void XmlScene::prepare(const render_command::Timeline& timeline) {
    GeometryModel geometry =
        geometry_model(*scene_, world_, {timeline.path, head_box_radius_eye(description_.head_radius_m, ipd_m_)});
    for (const std::string& note : geometry.notes)
        std::fprintf(stderr, "equistream render: note: %s\n", note.c_str());
    prepared_ = out_ / (".scene." + std::to_string(getpid()));
    std::error_code error;
    fs::create_directories(prepared_, error);
    if (error)
        throw InputError(expected_found(out_.string(), "a folder that can be written", error.message()));
    const fs::path model = prepared_ / model_name, description = prepared_ / description_name;
    description_.camera_path = timeline.path;
    description_.frames_per_second = timeline.frames_per_second;
    description_.model = model;
    write_glb(model, geometry.model);
    write_file_atomically(description, description_text(description_));
    description_.geometry_fingerprint = load_scene(description).geometry_fingerprint;
    std::uint64_t triangles = 0;
    for (const Instance& instance : geometry.model.instances)
        triangles += geometry.model.meshes[instance.mesh].triangles.size();
    char text[100];
    std::snprintf(text, sizeof text, "%zu shapes, %.2f M triangles in scene.glb", scene_->shapes().size(),
                  static_cast<double>(triangles) * 1e-6);
    figures_ = text;
}

/// Not before: a run that is refused must leave the geometry of the frames that are there.
void XmlScene::begin() {
    for (const char* name : {model_name, description_name})
        fs::rename(prepared_ / name, out_ / name);
}

XmlScene::~XmlScene() {
    std::error_code error;
    if (!prepared_.empty())
        fs::remove_all(prepared_, error);
}

}  // namespace equistream::mitsuba_host
