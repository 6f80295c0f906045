#include "stream.h"

#include "code_identity.h"

#include <equistream/error.h>

namespace equistream::embree_host {
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
    s.width = options.size.width;
    s.height = options.size.height;
    s.fov_x_rad = options.fov_rad;
    s.longitude_min = options.range.longitude_min;
    s.longitude_max = options.range.longitude_max;
    s.latitude_min = options.range.latitude_min;
    s.latitude_max = options.range.latitude_max;
    s.lock = options.lock;
    s.ipd_m = options.ipd_m;
    s.lean_m = scene.lean_m;
    s.frames_per_second = options.frames_per_second.value_or(scene.frames_per_second);
    s.exposure = scene.exposure;
    s.scene_name = scene.name.c_str();
    s.geometry_fingerprint = scene.geometry_fingerprint.c_str();
    s.overwrite = options.overwrite;
    s.single_part = options.single_part;
    return s;
}

Stream open_stream(es_sequence_settings settings, const std::filesystem::path& out, const std::string& name) {
    const std::string folder = (out / name).string();
    settings.output_dir = folder.c_str();
    es_error error{};
    es_sequence* sequence = nullptr;
    check(es_sequence_open(&settings, &sequence, &error), error);
    return {name, SequencePointer(sequence),
            static_cast<std::uint64_t>(settings.width) * static_cast<std::uint64_t>(settings.height),
            std::string_view(settings.aovs) != "none"};
}

}  // namespace

std::vector<Stream> open_streams(const RenderOptions& options, const SceneDescription& scene, const PosePath& path,
                                 const std::string& command) {
    // The code is part of the name: frames of a renderer that has changed since are not resumed.
    const std::string host = std::string("equistream-embree ") + es_version() + ", code " + code_identity();
    const std::string fingerprint = scene.fingerprint + " path " + path_fingerprint(path) + " bounces " +
                                    std::to_string(options.max_bounces) + (options.unbiased ? " unbiased" : "");
    es_sequence_settings settings = common_settings(options, scene);
    settings.host_name = host.c_str();
    settings.fingerprint = fingerprint.c_str();
    settings.command = command.c_str();
    settings.aovs = options.aovs.c_str();
    std::vector<Stream> streams;
    for (const es_eye eye : options.eyes) {
        settings.eye = eye;
        streams.push_back(open_stream(settings, options.out, eye_name(eye)));
    }
    if (options.small_eye) {
        settings.eye = *options.small_eye;
        settings.width /= 4;
        settings.height /= 4;
        settings.aovs = "none";
        streams.push_back(open_stream(settings, options.out, "small"));
    }
    return streams;
}

FramePointer begin_frame(const Stream& stream, const PosePath& path, std::int64_t index, std::int64_t path_frames,
                         double frames_per_second) {
    const auto head_at = [&](std::int64_t i) {
        return to_es_pose(path.at(static_cast<double>(i) / frames_per_second));
    };
    es_frame_settings settings{};
    settings.struct_size = sizeof(settings);
    settings.index = index;
    settings.time_s = static_cast<double>(index) / frames_per_second;
    settings.head = head_at(index);
    settings.head_previous = head_at(index > 0 ? index - 1 : index);
    settings.head_next = head_at(index + 1 < path_frames ? index + 1 : index);
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

}  // namespace equistream::embree_host
