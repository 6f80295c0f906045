#include "stream.h"

#include <equistream/aov_groups.h>
#include <equistream/error.h>
#include <equistream/sequence.h>
#include <equistream/text.h>

#include <tbb/global_control.h>

#include <algorithm>
#include <limits>

namespace equistream::render_command {
namespace {

void check(es_status status, const es_error& error) {
    if (status == ES_BAD_INPUT)
        throw InputError(error.text);
    if (status != ES_OK)
        throw WorkError(error.text);
}

es_pose to_es_pose(const Pose& pose) {
    const glm::dvec3& p = pose.position_m;
    const glm::dquat& q = pose.orientation;
    return {{p.x, p.y, p.z}, {q.w, q.x, q.y, q.z}};
}

double rate_of(const RenderOptions& options, const SceneDescription& scene) {
    return options.frames_per_second.value_or(scene.frames_per_second);
}

es_sequence_settings common_settings(const RenderOptions& options, const SceneDescription& scene) {
    es_sequence_settings s{};
    s.struct_size = sizeof(s);
    s.abi_version = ES_ABI_VERSION;
    s.spp = options.spp;
    s.samples_by_angle = options.samples_by_angle;
    s.seed = options.seed;
    s.camera = options.camera;
    s.fov_x_rad = options.fov_rad;
    s.longitude_min = options.range.longitude_min;
    s.longitude_max = options.range.longitude_max;
    s.latitude_min = options.range.latitude_min;
    s.latitude_max = options.range.latitude_max;
    s.lock = options.lock;
    s.ipd_m = options.ipd_m;
    s.head_radius_m = scene.head_radius_m;
    s.frames_per_second = rate_of(options, scene);
    s.exposure = scene.exposure;
    s.scene_name = scene.name.c_str();
    s.geometry_fingerprint = scene.geometry_fingerprint.c_str();
    s.overwrite = options.overwrite;
    s.single_part = options.single_part;
    s.denoise = options.denoise;
    s.denoise_threads = options.threads;
    s.part_count = options.part.count;
    s.part = options.part.number;
    return s;
}

/// What of the window decides its pixels and the base's.
std::string window_text(const WindowOptions& window) {
    const WindowPlace place = window_around(window.grid, window.middle);
    return " window " + (window.follows_gaze ? "gaze" : std::to_string(place.x) + "," + std::to_string(place.y)) + " " +
           size_text(window.grid.width, window.grid.height) + " of " + std::to_string(window.grid.columns);
}

/// What the plugin needs of a host to accumulate, beside what the user wants.
constexpr const char* aovs_to_accumulate = "depth,motion,normal,ids,specular,virtual";

/// What only frames that are accumulated have is left out.
std::string aovs_of_one_frame(const std::string& aovs) {
    std::string kept;
    for (const std::string_view name : split_at_commas(aovs))
        if (name != "samples" && name != "variance")
            kept.append(kept.empty() ? "" : ",").append(name);
    return kept.empty() ? "none" : kept;
}

/// Of a base: small tiles, so that most of what the window shows is whole tiles.
constexpr int base_tile_side = 16;

}  // namespace

bool StreamSettings::wants_guides() const {
    const std::vector<std::string> planes = parse_aov_groups(aovs);
    return denoised || std::ranges::find(planes, "guide_albedo") != planes.end();
}

bool StreamSettings::wants_ids() const {
    const std::vector<std::string> planes = parse_aov_groups(aovs);
    return std::ranges::find(planes, "crypto_object") != planes.end();
}

namespace {

/// Names as the plugin takes them. Borrows.
std::vector<const char*> pointers_to(std::vector<std::string>& names, const char* kind) {
    std::vector<const char*> pointers;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i].empty())
            names[i] = kind + std::to_string(i + 1);
        pointers.push_back(names[i].c_str());
    }
    return pointers;
}

}  // namespace

StreamOpener::StreamOpener(const RenderOptions& options, const SceneDescription& scene, const PosePath& path,
                           const RenderRecord& record)
    : options_(options), scene_(scene), path_(path), record_(record),
      fingerprint_(scene.fingerprint + " path " + path_fingerprint(path) + record.host.settings) {}

Stream StreamOpener::open(StreamSettings stream, std::uint32_t accumulated) const {
    es_sequence_settings settings = common_settings(options_, scene_);
    std::string fingerprint =
        fingerprint_ + (options_.window && (stream.window || stream.is_base) ? window_text(*options_.window) : "");
    if (accumulated > 0 && options_.frames && options_.frames->first > 0)  // what is carried on hangs on where it began
        fingerprint += " accumulated from " + std::to_string(options_.frames->first);
    const std::string folder = (options_.out / stream.name).string();
    stream.denoised = settings.denoise != ES_DENOISE_OFF;
    if (stream.tile_side == 0)
        stream.tile_side = record_.tile_side;
    settings.host_name = record_.host.name.c_str();
    settings.fingerprint = fingerprint.c_str();
    settings.command = record_.command.c_str();
    settings.accumulate_frames = accumulated;
    stream.accumulates = accumulated > 0;
    settings.output_dir = folder.c_str();
    settings.eye = stream.eye;
    settings.width = stream.size.width;
    settings.height = stream.size.height;
    settings.aovs = stream.aovs.c_str();
    settings.layer = stream.layer;
    settings.tile_side = stream.tile_side;
    if (stream.window) {
        settings.window_columns = stream.window->columns;
        settings.longitude_min = settings.longitude_max = settings.latitude_min = settings.latitude_max = 0;
    }
    if (const auto& atlas = stream.patches) {
        settings.patch_side = atlas->block_side;
        settings.patch_columns = atlas->columns;
        settings.patch_rows = atlas->rows;
        settings.patch_offset_count = static_cast<std::uint32_t>(atlas->offsets_m.size());
        settings.patch_offsets_m = &atlas->offsets_m.front().x;
    }
    HostNames names = stream.wants_ids() ? record_.names : HostNames{};
    const std::vector<const char*> objects = pointers_to(names.objects, "object "),
                                   materials = pointers_to(names.materials, "material ");
    settings.object_names = objects.data();
    settings.material_names = materials.data();
    settings.object_name_count = static_cast<std::uint32_t>(objects.size());
    settings.material_name_count = static_cast<std::uint32_t>(materials.size());
    es_error error{};
    es_sequence* sequence = nullptr;
    check(es_sequence_open(&settings, &sequence, &error), error);
    if (accumulated > 0)
        stream.aovs = (stream.aovs == "none" ? "" : stream.aovs + ",") + aovs_to_accumulate;
    return {std::move(stream), SequencePointer(sequence), folder};
}

/// Where it follows the gaze, its pixels are others from frame to frame: nothing is carried on.
Stream StreamOpener::window() const {
    const WindowOptions& window = *options_.window;
    const std::uint32_t accumulated = window.follows_gaze ? 0 : options_.accumulate;
    StreamSettings stream{"window",
                          options_.eyes.front(),
                          {window.grid.width, window.grid.height},
                          accumulated > 0 ? options_.aovs : aovs_of_one_frame(options_.aovs),
                          options_.spp};
    stream.window = window.grid;
    return open(std::move(stream), accumulated);
}

Stream StreamOpener::sphere(es_eye eye) const {
    StreamSettings stream{eye_name(eye), eye, options_.size, options_.aovs, options_.spp};
    stream.is_base = options_.window.has_value();
    if (stream.is_base && record_.tile_side == 0)
        stream.tile_side = base_tile_side;
    return open(std::move(stream), options_.accumulate);
}

bool StreamOpener::writes(std::string_view folder) const {
    return folder == "window"    ? options_.window.has_value()
           : folder == "hidden"  ? options_.layers
           : folder == "patches" ? options_.patches
           : folder == "small"   ? options_.small_eye.has_value()
                                 : std::ranges::find(options_.eyes, folder, eye_name) != options_.eyes.end();
}

/// Of the view that layers belong to, as players choose it: one that is there or is rendered now.
es_eye StreamOpener::main_eye() const {
    for (const es_eye eye : {ES_EYE_CENTRE, ES_EYE_LEFT})
        if (writes(eye_name(eye)) || std::filesystem::is_directory(options_.out / eye_name(eye)))
            return eye;
    return ES_EYE_RIGHT;
}

/// Before anything is replaced. Those of another one are not removed: they may be somebody's only ones.
void StreamOpener::require_companions() const {
    FrameInfo ours;
    ours.scene = scene_.name;
    ours.geometry_fingerprint = scene_.geometry_fingerprint;
    ours.ipd_m = options_.ipd_m;
    ours.exposure = scene_.exposure;
    ours.seed = options_.seed;
    const es_eye of_layers = main_eye();
    ours.eye = static_cast<Eye>(of_layers);
    using Beside = std::pair<const char*, TrackRole>;
    for (const auto& [name, role] :
         {Beside{"centre", TrackRole::main}, Beside{"left", TrackRole::main}, Beside{"right", TrackRole::main},
          Beside{"small", TrackRole::small}, Beside{"hidden", TrackRole::hidden}, Beside{"patches", TrackRole::patches},
          Beside{"window", TrackRole::window}}) {
        const std::filesystem::path folder = options_.out / name;
        if (writes(name) || !std::filesystem::exists(folder / "manifest.json") || list_frames(folder).empty())
            continue;
        // Where paths or frame rates differ, their first frames may still agree.
        const FrameInfo theirs = read_exr_info(folder / frame_file_name(list_frames(folder).back()));
        ours.index = theirs.index;
        ours.time_s = static_cast<double>(theirs.index) / rate_of(options_, scene_);
        ours.head = path_.at(ours.time_s);
        const Companion companion = role == TrackRole::main ? Companion::head : companion_of(role);
        const es_eye eye = companion == Companion::eye ? of_layers : options_.eyes.front();
        const std::filesystem::path main = options_.out / eye_name(eye);
        require_companion(companion, main, ours, folder, theirs, ", remove that folder or choose another --out");
    }
}

std::vector<Stream> StreamOpener::all() const {
    require_companions();
    std::vector<Stream> streams;
    if (options_.window)
        streams.push_back(window());
    for (const es_eye eye : options_.eyes)
        streams.push_back(sphere(eye));
    const es_eye eye = options_.eyes.front();
    if (options_.layers)
        streams.push_back(open({"hidden", eye, options_.size, "depth", options_.spp, ES_LAYER_HIDDEN}, 0));
    if (options_.patches)
        streams.push_back(open({"patches", eye, options_.size, "depth", options_.spp, ES_LAYER_FIRST,
                                empty_atlas(patch_settings(options_, scene_.head_radius_m))},
                               0));
    if (options_.small_eye)
        streams.push_back(open(
            {"small", *options_.small_eye, {options_.size.width / 4, options_.size.height / 4}, "none", options_.spp},
            0));
    return streams;
}

FramePointer begin_frame(const Stream& stream, const FrameTask& task, const FrameContents& contents) {
    std::vector<es_patch> patches;
    for (const PatchAtlas::Slot& s : contents.slots)
        patches.push_back({s.used, s.offset_index, s.block_x, s.block_y});
    es_frame_settings settings{};
    settings.struct_size = sizeof(settings);
    settings.index = task.index;
    settings.time_s = contents.time_s;
    settings.patches = patches.data();
    settings.patch_count = patches.size();
    settings.head = to_es_pose(task.head);
    settings.head_previous = to_es_pose(task.head_previous);
    settings.head_next = to_es_pose(task.head_next);
    settings.spp = task.spp == stream.settings.spp ? 0 : task.spp;
    settings.previous_frames = task.previous_frames;
    settings.window_x = task.window_place.x;
    settings.window_y = task.window_place.y;
    settings.window = contents.window != nullptr ? contents.window->sequence.get() : nullptr;
    es_error error{};
    es_frame* frame = nullptr;
    check(es_frame_begin(stream.sequence.get(), &settings, &frame, &error), error);
    return FramePointer(frame);
}

void end_frame(FramePointer frame) {
    es_error error{};
    if (es_frame_end(frame.release(), &error) != ES_OK)
        throw WorkError(error.text);
}

namespace {

/// Rays cast at a time: enough for a vectorised host, few enough to hold.
constexpr int rays_at_a_time = 1 << 19;

/// Depth spheres from the host's rays.
class SphereCaster {
public:
    SphereCaster(RenderHost& host, const Pose& pose) : host_(host), pose_(pose) {}

    void cast(const glm::dvec3& offset_m, const EquirectCamera& camera, ImageView<float> depth_m) {
        const glm::vec3 origin(pose_.position_m + pose_.orientation * offset_m);
        const int rows = std::max(1, rays_at_a_time / camera.width);
        for (int y = 0; y < camera.height; y += rows) {
            const int count = std::min(rows, camera.height - y);
            make_rays(origin, camera, y, count);
            host_.cast(rays_, {depth_m.row(y), rays_.size()});
        }
    }

private:
    void make_rays(const glm::vec3& origin, const EquirectCamera& camera, int first_row, int row_count) {
        rays_.assign(static_cast<std::size_t>(row_count) * static_cast<std::size_t>(camera.width), es_ray{});
        const double columns = camera.range.longitude_span() / camera.width;
        es_ray* ray = rays_.data();
        for (int y = first_row; y < first_row + row_count; ++y)
            for (int x = 0; x < camera.width; ++x, ++ray) {
                const glm::vec3 d = glm::normalize(glm::vec3(pose_.orientation * camera.direction(x + 0.5, y + 0.5)));
                for (int axis = 0; axis < 3; ++axis) {
                    ray->origin[axis] = origin[axis];
                    ray->direction[axis] = d[axis];
                }
                ray->t_max = std::numeric_limits<float>::infinity();
                ray->footprint_rad = static_cast<float>(columns);
            }
    }

    RenderHost& host_;
    Pose pose_;
    std::vector<es_ray> rays_;
};

bool same_layout(const PatchAtlas& a, const PatchAtlas& b) {
    return a.sphere_width == b.sphere_width && a.sphere_height == b.sphere_height && a.block_side == b.block_side &&
           a.columns == b.columns && a.rows == b.rows && a.offsets_m == b.offsets_m;
}

}  // namespace

PatchSettings patch_settings(const RenderOptions& options, double head_radius_m) {
    PatchSettings settings;
    settings.sphere = {options.size.width, options.size.height, options.range};
    settings.box_radius_m = head_box_radius(static_cast<Eye>(options.eyes.front()), head_radius_m, options.ipd_m);
    settings.budget = options.patch_budget_percent / 100;
    settings.block_side =
        options.patch_side > 0 ? options.patch_side : finest_patch_side(settings.sphere, settings.budget);
    if (!(settings.box_radius_m > 0))
        throw InputError(expected_found("--patches", "a head box: --ipd or head_box.lean_m above 0",
                                        "eyes that stay at the sphere's centre"));
    return settings;
}

FramePatches::FramePatches(const RenderOptions& options, double head_radius_m)
    : options_(options), settings_(patch_settings(options, head_radius_m)) {}

std::optional<PatchAtlas> FramePatches::atlas_before(std::int64_t index) const {
    if (last_ && last_index_ == index - 1)
        return last_;
    const std::filesystem::path file = options_.out / "patches" / frame_file_name(index - 1);
    if (!std::filesystem::exists(file))
        return std::nullopt;
    try {
        const std::optional<PatchAtlas> before = read_exr_info(file).patches;
        return before && same_layout(*before, empty_atlas(settings_)) ? before : std::nullopt;
    } catch (const InputError&) {
        return std::nullopt;  // a copy that was cut
    }
}

PatchPlan FramePatches::plan(RenderHost& host, const FrameTask& task) {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, options_.threads);
    const Pose pose = camera_pose(settings_.sphere, task.head, static_cast<Eye>(task.stream->eye), options_.ipd_m,
                                  options_.lock == ES_LOCK_PATH ? AxisLock::path : AxisLock::world);
    SphereCaster caster(host, pose);
    const std::optional<PatchAtlas> before = atlas_before(task.index);
    PatchPlan plan = plan_patches(
        settings_,
        [&](const glm::dvec3& offset_m, const EquirectCamera& camera, ImageView<float> depth_m) {
            caster.cast(offset_m, camera, depth_m);
        },
        before ? &*before : nullptr);
    last_ = plan.atlas;
    last_index_ = task.index;
    return plan;
}

HeadsWindow::HeadsWindow(const RenderOptions& options) : options_(options), follower_(options.window->grid) {}

WindowPlace HeadsWindow::at(const Pose& head, const std::optional<glm::dvec3>& gaze) {
    if (!options_.window->follows_gaze)
        return window_around(options_.window->grid, options_.window->middle);
    const glm::dvec3 looked_at = gaze.value_or(head.orientation * glm::dvec3(0, 0, -1));
    return follower_.place(options_.lock == ES_LOCK_PATH ? glm::conjugate(head.orientation) * looked_at : looked_at);
}

WindowPlace WindowPlaces::at(std::int64_t index) {
    while (static_cast<std::int64_t>(followed_.size()) <= index)
        followed_.push_back(
            window_.at(timeline_.path.at(timeline_.time_s(static_cast<std::int64_t>(followed_.size())))));
    return followed_[static_cast<std::size_t>(index)];
}

}  // namespace equistream::render_command
