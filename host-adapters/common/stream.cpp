#include "stream.h"

#include "frame_patches.h"

#include <equistream/error.h>

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

es_sequence_settings common_settings(const RenderOptions& options, const SceneDescription& scene) {
    es_sequence_settings s{};
    s.struct_size = sizeof(s);
    s.abi_version = ES_ABI_VERSION;
    s.spp = options.spp;
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
    s.frames_per_second = options.frames_per_second.value_or(scene.frames_per_second);
    s.exposure = scene.exposure;
    s.scene_name = scene.name.c_str();
    s.geometry_fingerprint = scene.geometry_fingerprint.c_str();
    s.overwrite = options.overwrite;
    s.single_part = options.single_part;
    return s;
}

Stream open_stream(es_sequence_settings settings, const std::filesystem::path& out, StreamSettings stream) {
    const std::string folder = (out / stream.name).string();
    settings.output_dir = folder.c_str();
    settings.eye = stream.eye;
    settings.width = stream.size.width;
    settings.height = stream.size.height;
    settings.aovs = stream.aovs.c_str();
    settings.layer = stream.layer;
    if (const auto& atlas = stream.patches) {
        settings.patch_side = atlas->block_side;
        settings.patch_columns = atlas->columns;
        settings.patch_rows = atlas->rows;
        settings.patch_offset_count = static_cast<std::uint32_t>(atlas->offsets_m.size());
        settings.patch_offsets_m = &atlas->offsets_m.front().x;
    }
    es_error error{};
    es_sequence* sequence = nullptr;
    check(es_sequence_open(&settings, &sequence, &error), error);
    return {std::move(stream), SequencePointer(sequence)};
}

}  // namespace

std::vector<Stream> open_streams(const RenderOptions& options, const SceneDescription& scene, const PosePath& path,
                                 const RenderRecord& record) {
    const std::string fingerprint = scene.fingerprint + " path " + path_fingerprint(path) + record.host.settings;
    es_sequence_settings settings = common_settings(options, scene);
    settings.host_name = record.host.name.c_str();
    settings.fingerprint = fingerprint.c_str();
    settings.tile_side = record.tile_side;
    settings.command = record.command.c_str();
    std::vector<Stream> streams;
    for (const es_eye eye : options.eyes)
        streams.push_back(
            open_stream(settings, options.out, {eye_name(eye), eye, options.size, options.aovs, options.spp}));
    if (options.layers)
        streams.push_back(
            open_stream(settings, options.out,
                        {"hidden", options.eyes.front(), options.size, "depth", options.spp, ES_LAYER_HIDDEN}));
    if (options.patches)
        streams.push_back(open_stream(settings, options.out,
                                      {"patches", options.eyes.front(), options.size, "depth", options.spp,
                                       ES_LAYER_FIRST, empty_atlas(patch_settings(options, scene.head_radius_m))}));
    if (options.small_eye) {
        const cli::Size quarter{options.size.width / 4, options.size.height / 4};
        streams.push_back(
            open_stream(settings, options.out, {"small", *options.small_eye, quarter, "none", options.spp}));
    }
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

}  // namespace equistream::render_command
