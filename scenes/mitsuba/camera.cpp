#include "camera.h"

#include "xml.h"

#include <equistream/camera.h>

namespace equistream::mitsuba_xml {
namespace {

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

}  // namespace

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

}  // namespace equistream::mitsuba_xml
