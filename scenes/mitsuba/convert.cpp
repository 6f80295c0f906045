#include "convert.h"

#include "shapes.h"
#include "xml.h"

#include <equistream/camera.h>
#include <equistream/sequence.h>

#include <sstream>

namespace equistream {

using namespace mitsuba_xml;

namespace {

/// Mitsuba counts the ray from the camera too.
constexpr std::uint32_t max_depth = default_max_bounces + 1;

MitsubaSettings completed(MitsubaSettings settings) {
    const bool sphere = settings.camera == MitsubaCamera::equirect;
    if (settings.width == 0 && settings.height == 0) {
        settings.width = sphere ? 2048 : 1280;
        settings.height = sphere ? 1024 : 720;
    }
    return settings;
}

/// Parameters that `mitsuba -D` and load_file(...) can change.
void add_default(pugi::xml_node scene, const char* name, int value) {
    pugi::xml_node node = scene.append_child("default");
    node.append_attribute("name") = name;
    node.append_attribute("value") = value;
}

/// Nothing nearer can be seen in perspective; a sphere sees everything.
constexpr double near_clip_m = 1e-3;

/// Mitsuba's camera frame is +X left, +Y up, +Z forward.
glm::dmat4 mitsuba_from_pose(const Pose& pose) {
    const auto axis = [&](const glm::dvec3& v) { return glm::dvec4(pose.orientation * v, 0); };
    return {axis({-1, 0, 0}), axis({0, 1, 0}), axis({0, 0, -1}), glm::dvec4(pose.position_m, 1)};
}

void add_film(pugi::xml_node sensor) {
    pugi::xml_node film = add_plugin(sensor, "film", "hdrfilm");
    add_integer(film, "width", "$width");
    add_integer(film, "height", "$height");
    add_text(film, "pixel_format", "rgba");
    add_text(film, "component_format", "float32");
    add_plugin(film, "rfilter", "box");
    add_integer(add_plugin(sensor, "sampler", "independent"), "sample_count", "$spp");
}

/// The camera path's pose. `farthest_m`: how far rays have to reach.
void add_sensor(pugi::xml_node scene, const SceneDescription& description, const MitsubaSettings& settings,
                double farthest_m) {
    const double time_s = static_cast<double>(settings.frame) / description.frames_per_second;
    const Pose head = description.camera_path.at(time_s);
    const bool sphere = settings.camera == MitsubaCamera::equirect;
    const Camera camera = sphere ? Camera(EquirectCamera{}) : Camera(PerspectiveCamera{});
    pugi::xml_node sensor = add_plugin(scene, "sensor", sphere ? "equirect" : "perspective", "camera");
    add_transform(sensor, "to_world",
                  mitsuba_from_pose(camera_pose(camera, head, Eye::centre, default_ipd_m, AxisLock::world)));
    if (!sphere) {
        add_float(sensor, "fov", 90);
        add_text(sensor, "fov_axis", "x");
        add_float(sensor, "near_clip", near_clip_m);
        add_float(sensor, "far_clip", farthest_m);
    }
    add_film(sensor);
}

void add_note(MitsubaReport& report, std::size_t count, const std::string& text) {
    if (count > 0)
        report.notes.push_back(std::to_string(count) + " " + text);
}

void add_notes(MitsubaReport& report, const MaterialNotes& notes) {
    add_note(report, notes.principled, "metal-rough materials became principled, which is near but not the same");
    add_note(report, notes.metals, "metals became conductors, whose reflectance is near but not the same");
    add_note(report, notes.mixed_glass,
             "kinds of glass became a blend of thindielectric with opaque materials, near but not the same");
}

std::string document_text(const pugi::xml_document& document) {
    std::ostringstream text;
    document.save(text, "  ");
    return text.str();
}

}  // namespace

MitsubaReport write_mitsuba_scene(const SceneModel& model, const SceneDescription& scene,
                                  const std::filesystem::path& file, const MitsubaSettings& given) {
    const MitsubaSettings settings = completed(given);
    const double time_s = static_cast<double>(settings.frame) / scene.frames_per_second;
    const std::vector<glm::mat4> transforms = instance_transforms(model, scene, time_s);
    const std::vector<std::uint32_t> moving = find_moving_instances(model, scene);

    AssetFolder folder(file, settings.overwrite);
    Images images(model, folder);
    Materials materials(model, images);
    Shapes shapes(model, transforms, moving, materials, settings.bake);
    materials.ask_for_images();
    shapes.ask_for_images(images);

    pugi::xml_document document;
    pugi::xml_node root = document.append_child("scene");
    root.append_attribute("version") = "3.0.0";
    add_default(root, "width", settings.width);
    add_default(root, "height", settings.height);
    add_default(root, "spp", settings.samples_per_pixel);
    images.declare(root);
    materials.declare(root);
    shapes.declare(root, folder, images);
    const Bounds bounds = shapes.bounds();
    add_sky(root, scene, folder);
    add_sun(root, scene, bounds);
    if (shapes.only_unsampled_lights() && !root.find_child_by_attribute("id", "sky") &&
        !root.find_child_by_attribute("id", "sun"))
        add_darkness(root);
    add_sensor(root, scene, settings, 10 * sun_distance_m(bounds));
    // path takes what a mask cut away, and glass, for opaque where it asks whether a light is seen.
    add_integer(add_plugin(root, "integrator", materials.any_straight() ? "volpath" : "path", "integrator"),
                "max_depth", std::to_string(max_depth).c_str());

    images.write();
    shapes.write_meshes(folder);
    MitsubaReport report;
    report.triangles = model.triangle_count();
    report.images = images.count();
    report.bytes = folder.bytes();
    shapes.report(report);
    add_notes(report, materials.notes());
    add_note(report, images.wrapped_alike(),
             "images repeat too often along v to be written out: they wrap there as along u");
    folder.place();
    write_file_atomically(file, document_text(document));
    folder.keep();
    return report;
}

}  // namespace equistream
