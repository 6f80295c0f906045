#include "mitsuba_scenes.h"

#include "child_process.h"
#include "geometry_model.h"

#include <equistream/bound.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/sequence.h>
#include <equistream/text.h>

#include <programs/cli/process.h>
#include <scenes/library/model.h>
#include <scenes/library/write_glb.h>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include <charconv>
#include <cstdio>
#include <numeric>

namespace equistream::mitsuba_host {

namespace fs = std::filesystem;

namespace {

glm::mat4 matrix_from(const nlohmann::json& numbers) {
    glm::mat4 matrix;
    for (int i = 0; i < 16; ++i)
        matrix[i / 4][i % 4] = numbers.at(static_cast<std::size_t>(i)).get<float>();
    return matrix;
}

/// K of "instance-K" and of "instance-K-back", the other side of a shape that shines on both.
std::uint32_t instance_of(const std::string& id) {
    const std::string prefix = "instance-";
    std::uint32_t number = no_index;
    if (id.starts_with(prefix))
        std::from_chars(id.data() + prefix.size(), id.data() + id.size(), number);
    return number;
}

/// World after from world before, for one that moved.
glm::dmat4 displacement(const glm::mat4& before, const glm::mat4& after) {
    return glm::dmat4(after) * glm::inverse(glm::dmat4(before));
}

std::vector<float> transformed(const glm::dmat4& matrix, const std::vector<float>& points, double w) {
    std::vector<float> result(points.size());
    for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
        glm::dvec3 p(matrix * glm::dvec4(points[i], points[i + 1], points[i + 2], w));
        if (w == 0)
            p = glm::normalize(p);
        for (int c = 0; c < 3; ++c)
            result[i + static_cast<std::size_t>(c)] = static_cast<float>(p[c]);
    }
    return result;
}

}  // namespace

OwnScene::OwnScene(const LoadContext& context) : description_(load_scene(context.options.scene)) {
    const auto start = Clock::now();
    read_placements();
    const fs::path xml = converted(context);
    char text[80];
    std::snprintf(text, sizeof text, "converted in %.2f s, ", seconds_since(start));
    SceneRequest request;
    request.xml = xml;
    request.aovs = context.aovs;
    request.sensors = context.sensors;
    // Mitsuba counts the ray from the camera too.
    request.max_depth = static_cast<int>(context.host.max_bounces.value_or(default_max_bounces)) + 1;
    scene_ = EmbeddedScene::load(context.engine, request);
    number_shapes();
    figures_ = text + std::to_string(scene_->shapes().size()) + " shapes";
}

void OwnScene::read_placements() {
    const auto json = nlohmann::json::parse(run_beside("equistream-scene", {"placements", description_.file.string()}));
    for (const auto& object : json.at("objects"))
        placements_.objects.push_back({object.at("name").get<std::string>(), object.at("parent").get<int>(),
                                       matrix_from(object.at("world_from_object"))});
    for (const auto& instance : json.at("instances")) {
        // As many meshes as instances, so that each has its material.
        Mesh mesh;
        mesh.material = instance.at("material").get<std::uint32_t>();
        placements_.instances.push_back({static_cast<std::uint32_t>(placements_.meshes.size()),
                                         instance.at("object").get<std::uint32_t>(),
                                         matrix_from(instance.at("world_from_object"))});
        placements_.meshes.push_back(std::move(mesh));
    }
    for (const auto& name : json.at("materials"))
        placements_.materials.emplace_back().name = name.get<std::string>();
    at_zero_ = instance_transforms(placements_, description_, 0);
    moves_.assign(placements_.instances.size(), 0);
    for (const std::uint32_t instance : find_moving_instances(placements_, description_))
        moves_[instance] = 1;
}

/// Kept below --out, because converting a large scene takes longer than reading what came of it.
fs::path OwnScene::converted(const LoadContext& context) {
    converter_ = content_fingerprint({cli::own_folder() / "equistream-scene"}, "");
    const fs::path folder = context.options.out / ".mitsuba" / (description_.fingerprint + "-" + converter_);
    const fs::path xml = folder / "scene.xml";
    std::error_code error;
    if (fs::exists(xml, error))  // written last
        return xml;
    fs::create_directories(folder, error);
    if (error)
        throw WorkError(folder.string() + ": cannot be made: " + error.message());
    run_beside("equistream-scene", {"convert", description_.file.string(), xml.string(), "--bake", "--overwrite"});
    return xml;
}

/// As the embedded host numbers them.
void OwnScene::number_shapes() {
    ShapeIds ids;
    const auto add = [&](std::uint32_t k) {
        const bool known = k < placements_.instances.size();
        const Instance& instance = placements_.instances[known ? k : 0];
        ids.object.push_back(known ? instance.object + 1 : no_surface_id);
        ids.material.push_back(known ? placements_.meshes[instance.mesh].material + 1 : no_surface_id);
        ids.instance.push_back(known ? k + 1 : no_surface_id);
        return known;
    };
    const auto shapes = static_cast<std::uint32_t>(scene_->shapes().size());
    for (std::uint32_t i = 0; i < shapes; ++i) {
        const std::vector<std::uint32_t> merged = scene_->face_instances(i);
        ids.first_face.push_back(merged.empty() ? 0 : static_cast<std::uint32_t>(ids.face_entry.size() + 1));
        for (const std::uint32_t k : merged)
            ids.face_entry.push_back(shapes + k);
        const ShapeSummary& shape = scene_->shapes()[i];
        const std::uint32_t k = merged.empty() ? instance_of(shape.id) : merged.front();
        if (add(k) && merged.empty() && moves_[k] != 0)
            moving_.push_back({i, k, shape.is_mesh, shape.is_mesh ? scene_->mesh(-1, i) : MeshBuffers{}});
    }
    for (std::uint32_t k = 0; k < placements_.instances.size() && !ids.face_entry.empty(); ++k)
        add(k);
    scene_->set_ids(ids);
}

render_command::HostNames OwnScene::names() const {
    render_command::HostNames names;
    for (const Object& object : placements_.objects)
        names.objects.push_back(object.name);
    for (const Material& material : placements_.materials)
        names.materials.push_back(material.name);
    return names;
}

void OwnScene::place(const MovingShape& shape, const glm::mat4& now) {
    if (!shape.is_mesh) {
        scene_->place_instance(shape.shape, rows_of(glm::dmat4(now)));
        return;
    }
    const glm::dmat4 since_zero = displacement(at_zero_[shape.instance], now);
    const glm::dmat4 normals(glm::transpose(glm::inverse(glm::dmat3(since_zero))));
    scene_->place_vertices(shape.shape, transformed(since_zero, shape.at_rest.positions, 1),
                           transformed(normals, shape.at_rest.normals, 0));
}

void OwnScene::move_to(const render_command::FrameTimes& times) {
    if (moving_.empty())
        return;
    const auto now = instance_transforms(placements_, description_, times.now_s);
    const auto previous = instance_transforms(placements_, description_, times.previous_s);
    const auto next = instance_transforms(placements_, description_, times.next_s);
    const Matrix34 unmoved{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    std::vector<float> to_previous, to_next;
    for (std::size_t i = 0; i < scene_->shapes().size(); ++i)
        for (auto* table : {&to_previous, &to_next})
            table->insert(table->end(), unmoved.begin(), unmoved.end());
    for (const MovingShape& shape : moving_) {
        place(shape, now[shape.instance]);
        const Matrix34 back = rows_of(displacement(now[shape.instance], previous[shape.instance]));
        const Matrix34 on = rows_of(displacement(now[shape.instance], next[shape.instance]));
        std::copy(back.begin(), back.end(), to_previous.begin() + static_cast<std::ptrdiff_t>(12 * shape.shape));
        std::copy(on.begin(), on.end(), to_next.begin() + static_cast<std::ptrdiff_t>(12 * shape.shape));
    }
    scene_->commit_placements();
    scene_->set_moved(to_previous, to_next);
}

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
        throw InputError(std::string(problem.what()) + "; Mitsuba 3 needs " + std::to_string(changes.size()) +
                         " changes, listed above");
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
    description_.name = scene_name_of(request.xml);
    description_.head_radius_m = context.host.head_radius_m;
    description_.camera_path = PosePath({{0, world_.pose(sensor.to_world)}}, request.xml.string());
    if (!sensor.has_pose && context.options.path.empty())
        std::fprintf(stderr, "equistream render: note: %s; the head stands at its origin\n",
                     sensor.count == 0 ? "the XML has no sensor" : "the XML's sensor has no to_world");
    if (sensor.has_clips)
        std::fprintf(stderr,
                     "equistream render: note: %s ignores the sensor's near_clip and far_clip; `play --scene` may give "
                     "depth of surfaces that were clipped\n",
                     model_name);
    description_.fingerprint = content_fingerprint(sensor.files, parameters_text(context.host) + "\n" + sensor.spectra);
}

/// As the integrator counts them where nobody numbers them: shapes, and materials as they are met.
render_command::HostNames XmlScene::names() const {
    render_command::HostNames names;
    const auto add_material = [&](const ShapeSummary& shape) {
        const bool is_known =
            !shape.bsdf.empty() && std::ranges::find(names.materials, shape.bsdf) != names.materials.end();
        if (shape.group < 0 && !is_known)
            names.materials.push_back(shape.bsdf);
    };
    for (const ShapeSummary& shape : scene_->shapes()) {
        names.objects.push_back(shape.id);
        add_material(shape);
    }
    for (const ShapeGroup& group : scene_->groups())
        std::ranges::for_each(group.shapes, add_material);
    return names;
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
