#include "mitsuba_host.h"
#include "child_process.h"
#include "frame_planes.h"

#include <equistream/aov.h>
#include <equistream/aov_groups.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <host-adapters/common/host.h>
#include <programs/cli/process.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <limits>

namespace equistream::mitsuba_host {

using namespace render_command;

namespace fs = std::filesystem;

namespace {

/// Samples a pass may take: each is a lane of the vectorised variants and needs memory of its own. An interrupt waits
/// for the end of a pass, and scalar variants are slow.
std::uint32_t samples_of_a_pass(const std::string& variant, std::uint64_t pixels, std::uint32_t samples) {
    const bool is_scalar = variant.starts_with("scalar");
    std::uint64_t most = (std::uint64_t{1} << (is_scalar ? 20 : 23)) / pixels;
    // A scalar variant tells 2^32 / pixels seeds apart, where pixels are a power of two.
    if (is_scalar)
        most = std::max(most, samples * pixels >> 30);
    return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(most, 1, samples));
}

/// Where plugins/ may lie: beside the folder of programs in a build tree and in a Python package, below lib where
/// installed.
fs::path find_plugin_root() {
    const fs::path prefix = cli::own_folder().parent_path();
    std::string tried;
    std::error_code error;
    for (const fs::path& root :
         {prefix, prefix / "lib/equistream", prefix / "lib/x86_64-linux-gnu/equistream", prefix / "lib64/equistream"}) {
        if (fs::exists(root / "plugins/equirect_aov.so", error) && fs::exists(root / "plugins/equirect.so", error))
            return root;
        tried += (tried.empty() ? "" : ", ") + (root / "plugins").string();
    }
    throw InputError(
        expected_found("equistream-render-mitsuba", "equirect.so and equirect_aov.so in one of " + tried, "none"));
}

SphereRange in_degrees(const LongitudeLatitudeRange& range) {
    const auto degrees = [](double rad) { return rad * 180 / pi; };
    return {degrees(range.longitude_min), degrees(range.longitude_max), degrees(range.latitude_min),
            degrees(range.latitude_max)};
}

/// The pictures', then the small one's, then the windows'; of omnidirectional stereo one for each eye.
std::vector<SensorRequest> sensor_requests(const RenderOptions& options, double unit_m) {
    SensorRequest request;
    request.width = options.size.width;
    request.height = options.size.height;
    request.perspective = options.camera == ES_PERSPECTIVE;
    request.fov_x_deg = options.fov_rad * 180 / pi;
    request.range = in_degrees(options.range);
    if (options.camera == ES_ODS) {
        std::vector<SensorRequest> eyes;
        for (const es_eye eye : options.eyes) {
            request.ods_ipd = options.ipd_m / unit_m;
            request.ods_eye = eye == ES_EYE_LEFT ? "ods_left" : "ods_right";
            eyes.push_back(request);
        }
        return eyes;
    }
    std::vector<SensorRequest> requests{request};
    if (options.small_eye) {
        request.width /= 4;
        request.height /= 4;
        requests.push_back(request);
    }
    for (const WindowGrid& grid : window_grids(options)) {
        request.width = grid.width;
        request.height = grid.height;
        requests.push_back(request);
    }
    return requests;
}

/// What is asked for of the AOV integrator, and ids besides: they tell the sun's disc from surfaces.
std::string aovs_to_render(const RenderOptions& options) {
    std::string groups;
    const std::string wanted = options.accumulate > 0 ? "all" : options.aovs;
    for (const std::string& plane : parse_aov_groups(wanted))
        if (const AovInfo aov = *find_aov(plane); aov.in_all && plane != "colour")
            groups += std::string(aov.group) + ",";
    return groups.empty() ? "none" : groups + "ids";
}

/// Mixes all bits of all inputs (the finaliser of SplitMix64).
std::uint64_t mixed(std::uint64_t state, std::uint64_t value) {
    std::uint64_t z = state * 0x9e3779b97f4a7c15u + value + 0x632be59bd9b4e019u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

}  // namespace

HostText MitsubaHost::text() const {
    return {"mitsuba", "Renders a scene with Mitsuba 3 along a camera path into EXR sequences.",
            "equistream render --host mitsuba cbox.xml --up auto --size 1920x960 --spp 128 --out frames",
            "Scene description (JSON), or a scene in Mitsuba's XML"};
}

void MitsubaHost::add_options(cli::CommandLine& app) {
    app_ = &app;
    add_host_options(app, host_options_);
}

const SceneDescription& MitsubaHost::describe(const RenderOptions& options) {
    options_ = options;
    const bool is_xml = options.scene.extension() == ".xml";
    if (!is_xml)
        require_xml_options_unused(*app_);
    rendered_aovs_ = aovs_to_render(options);
    const std::vector<std::string> planes = parse_aov_groups(options.aovs);
    const auto is_asked_for = [&](const char* plane) { return std::ranges::find(planes, plane) != planes.end(); };
    if (is_asked_for("crypto_object") && is_asked_for("reference"))
        throw InputError(expected_found("--aovs", "cryptomatte or reference: mitsuba renders either", "both"));
    plugin_root_ = find_plugin_root();
    engine_.emplace(EngineOptions{host_options_.variant, options.threads, plugin_root_});
    source_ =
        open_scene({*engine_, options_, host_options_, sensor_requests(options, host_options_.unit_m), rendered_aovs_});
    return source_->description();
}

void MitsubaHost::load(const RenderOptions&, const Timeline& timeline) {
    source_->prepare(timeline);
}

void MitsubaHost::begin() {
    source_->begin();
}

HostRecord MitsubaHost::record() const {
    const std::string plugins =
        content_fingerprint({plugin_root_ / "plugins/equirect.so", plugin_root_ / "plugins/equirect_aov.so"}, "");
    // The code is part of the name: frames of plugins or of a program that have changed since are not resumed.
    return {std::string("equistream-mitsuba ") + es_version() + ", mitsuba " + Engine::release() + " " +
                engine_->variant() + ", code " + code_identity() + " plugins " + plugins.substr(0, 8) + source_->code(),
            host_options_.max_bounces ? " bounces " + std::to_string(*host_options_.max_bounces) : ""};
}

HostNames MitsubaHost::names() const {
    return source_->names();
}

void MitsubaHost::move_to(const FrameTimes& times) {
    source_->move_to(times);
}

void MitsubaHost::cast(std::span<const es_ray> rays, std::span<float> distances_m) {
    const auto start = Clock::now();
    std::ranges::copy(TileRays(source_->scene(), source_->world()).distances_m(rays), distances_m.begin());
    mitsuba_s_ += seconds_since(start);
}

std::size_t MitsubaHost::sensor_of(const StreamSettings& stream) const {
    if (options_.camera == ES_ODS)
        return std::size_t(std::ranges::find(options_.eyes, stream.eye) - options_.eyes.begin());
    if (stream.window) {
        const std::vector<WindowGrid> grids = window_grids(options_);
        return (options_.small_eye ? 2 : 1) + std::size_t(std::ranges::find(grids, *stream.window) - grids.begin());
    }
    return stream.name == "small" ? 1 : 0;
}

std::uint32_t MitsubaHost::seed_of(std::int64_t frame, std::size_t sensor, std::uint32_t pass) const {
    // Scalar variants multiply the seed by the film's pixels and keep 32 bits: consecutive seeds stay apart.
    const std::uint64_t state = mixed(options_.seed, static_cast<std::uint64_t>(frame));
    return static_cast<std::uint32_t>(mixed(state, sensor)) + pass;
}

void MitsubaHost::render(const FrameTask& task) {
    if (task.stream->layer == ES_LAYER_FIRST && !task.stream->patches) {
        render_planes(task);
        return;
    }
    render_tiles(task, false);
}

/// Where rays begin no sensor of Mitsuba's can be told, so they come from the plugin, tile by tile.
void MitsubaHost::render_tiles(const FrameTask& task, bool ids_alone) {
    const auto start = Clock::now();
    const std::size_t sensor = sensor_of(*task.stream);
    const glm::dvec3 axis =
        options_.camera == ES_PERSPECTIVE ? task.head.orientation * glm::dvec3(0, 0, -1) : glm::dvec3(0);
    TileRays rays(source_->scene(), source_->world(), axis);
    left_out_samples_ += rays.render(task, sensor, ids_alone, [&](std::uint32_t tile, std::uint32_t pass) {
        return static_cast<std::uint32_t>(mixed(
            seed_of(task.index, static_cast<std::size_t>(task.stream->eye) + (task.stream->patches ? 9 : 6), pass),
            tile));
    });
    mitsuba_s_ += seconds_since(start);
}

Camera MitsubaHost::camera_of(const FrameTask& task) const {
    const StreamSettings& stream = *task.stream;
    if (stream.window)
        return window_camera(*stream.window, task.window_place);
    if (options_.camera == ES_PERSPECTIVE)
        return PerspectiveCamera{stream.size.width, stream.size.height, options_.fov_rad};
    const double side_m = options_.camera == ES_ODS ? ods_side_m(static_cast<Eye>(stream.eye), options_.ipd_m) : 0;
    return EquirectCamera{stream.size.width, stream.size.height, options_.range, side_m};
}

void MitsubaHost::render_planes(const FrameTask& task) {
    const StreamSettings& stream = *task.stream;
    const std::size_t sensor = sensor_of(stream);
    const Camera camera = camera_of(task);
    const auto pose = [&](const Pose& head) {
        return camera_pose(camera, head, static_cast<Eye>(stream.eye), options_.ipd_m,
                           options_.lock == ES_LOCK_PATH ? AxisLock::path : AxisLock::world);
    };
    const WorldMap& world = source_->world();
    CameraPlacement placement{world.to_world(pose(task.head_previous)), world.to_world(pose(task.head)),
                              world.to_world(pose(task.head_next))};
    if (stream.window)
        placement.range = in_degrees(std::get<EquirectCamera>(camera).range);
    source_->scene().place_camera(sensor, placement);

    FramePlanes planes(stream.size.width, stream.size.height, stream.wants_geometry() ? rendered_aovs_ : "none");
    const std::uint32_t most = samples_of_a_pass(engine_->variant(), stream.pixels(), std::max(task.spp, 1u));
    std::uint32_t pass = 0;
    for (std::uint32_t done = 0; done < task.spp; ++pass) {
        if (*task.stop)
            return;
        const std::uint32_t samples = std::min(most, task.spp - done);
        const auto start = Clock::now();
        const bool geometry = pass == 0 && stream.wants_geometry();
        const PassResult result = source_->scene().render(
            sensor, samples, seed_of(task.index, static_cast<std::size_t>(stream.eye) + 3 * sensor, pass), geometry,
            stream.wants_guides());
        mitsuba_s_ += seconds_since(start);
        planes.add(result, samples);
        done += samples;
        task.paths_traced(stream.pixels() * samples);
    }
    planes.bring_home(world);
    // Accumulated light takes NaN for no samples, and black for black.
    planes.hand_over(task.frame, stream.aovs, stream.accumulates ? std::numeric_limits<float>::quiet_NaN() : 0);
    left_out_samples_ += planes.left_out_samples();
    render_tiles(task, stream.wants_ids());  // what is left: Cryptomatte's, or those of group "reference"
}

HostFigures MitsubaHost::figures(double, nlohmann::json& json) const {
    json["variant"] = engine_->variant();
    json["mitsuba_s"] = mitsuba_s_;
    json["shapes"] = source_->scene().shapes().size();
    char rates[48];
    std::snprintf(rates, sizeof rates, "%.2f s of it in Mitsuba", mitsuba_s_);
    return {"mitsuba " + Engine::release() + " " + engine_->variant() + ", " + source_->figures(), rates,
            left_out_samples_};
}

}  // namespace equistream::mitsuba_host
