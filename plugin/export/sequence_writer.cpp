#include "frame_json.h"

#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/sequence_writer.h>
#include <equistream/text.h>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace equistream {
namespace {

constexpr const char* off = "off";

/// Everything that decides pixels, by the name a host knows it by.
std::vector<std::pair<const char*, std::string>> deciding_settings(const Manifest& manifest) {
    const FrameInfo& info = manifest.shared;
    std::string planes;
    for (const std::string& plane : manifest.planes)
        planes += (planes.empty() ? "" : ",") + plane;
    std::vector<std::pair<const char*, std::string>> list = {
        {"camera", is_ods(info.camera)                                   ? "ods"
                   : std::holds_alternative<EquirectCamera>(info.camera) ? "equirect"
                                                                         : "perspective"},
        {"size", size_text(width_of(info.camera), height_of(info.camera))},
        {"spp", std::to_string(info.samples_per_pixel)},
        {"seed", std::to_string(info.seed)},
        {"eye", std::to_string(static_cast<int>(info.eye))},
        {"lock", std::to_string(static_cast<int>(info.lock))},
        {"ipd_m", in_words(info.ipd_m)},
        {"lean_m", in_words(info.head_radius_m)},
        {"frames_per_second", in_words(info.frames_per_second)},
        {"exposure", in_words(info.exposure)},
        {"aovs", planes},
        {"scene_name", "\"" + info.scene + "\""},
        {"host_name", "\"" + info.host + "\""},
        {"geometry_fingerprint", "\"" + info.geometry_fingerprint + "\""},
        {"denoise", info.denoiser.empty() ? off : "\"" + info.denoiser + "\""},
        {"accumulate", info.accumulated_frames == 0 ? off : std::to_string(info.accumulated_frames)}};
    if (const auto* sphere = std::get_if<EquirectCamera>(&info.camera)) {
        const LongitudeLatitudeRange& range = sphere->range;
        list.emplace_back("longitudes", in_words(range.longitude_min) + " to " + in_words(range.longitude_max));
        list.emplace_back("latitudes", in_words(range.latitude_min) + " to " + in_words(range.latitude_max));
    } else {
        list.emplace_back("fov_x_rad", in_words(std::get<PerspectiveCamera>(info.camera).fov_x_rad));
    }
    list.emplace_back("window_columns", info.window_columns == 0 ? off : std::to_string(info.window_columns));
    if (info.patches)
        list.emplace_back("patches", patches_to_json(*info.patches).dump());
    return list;
}

}  // namespace

// FNV-1a, 64 bits: names a set of settings; not against forgery.
std::string sequence_fingerprint(const Manifest& manifest, const std::string& of_host) {
    std::string text = of_host;
    for (const auto& [name, value] : deciding_settings(manifest))
        if (value != off)  // as before there was a denoiser, and a history
            text += std::string("\n") + name + "=" + value;
    std::uint64_t hash = 0xcbf29ce484222325ull;
    for (const char c : text)
        hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
    char digits[20];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
    return digits;
}

std::optional<std::string> difference(const Manifest& expected, const Manifest& found) {
    const auto before = deciding_settings(expected);
    const auto now = deciding_settings(found);
    for (std::size_t i = 0; i < std::min(before.size(), now.size()); ++i)
        if (before[i] != now[i])
            return std::string("expected ") + before[i].first + " " + before[i].second +
                   " as in the frames there, found " + now[i].second +
                   (before[i].first == std::string_view("host_name") ? " (another renderer, or its code has changed)"
                                                                     : "");
    if (expected.single_part && found.single_part && *expected.single_part != *found.single_part)
        return std::string("expected single_part ") + (*expected.single_part ? "1" : "0") +
               " as in the frames there, found " + (*found.single_part ? "1" : "0");
    if (expected.fingerprint != found.fingerprint)
        return "expected fingerprint " + expected.fingerprint + " as in the frames there, found " + found.fingerprint +
               " (the scene, the path or the host's own settings changed)";
    return std::nullopt;
}

namespace {

void require_utf8(const FrameInfo& shared) {
    for (const auto& [name, value] :
         {std::pair("scene_name", &shared.scene), std::pair("host_name", &shared.host),
          std::pair("geometry_fingerprint", &shared.geometry_fingerprint), std::pair("denoiser", &shared.denoiser)})
        if (!is_utf8(*value))
            throw InputError(
                expected_found(name, "UTF-8, as a manifest holds it", "\"" + as_json_holds(*value) + "\""));
}

/// Readers refuse what lies beyond.
void require_readable(const std::string& file, const FrameInfo& info) {
    for (const auto& [what, mismatch] :
         {std::pair(": frame number", range_mismatch(static_cast<double>(info.index), 0, max_frame_index)),
          std::pair(": frame time", range_mismatch(info.time_s, -max_time_s, max_time_s))})
        if (mismatch)
            throw InputError(expected_found(file + what, mismatch->expected, mismatch->found));
}

}  // namespace

SequenceWriter::SequenceWriter(SequenceSettings settings) : settings_(std::move(settings)) {
    require_utf8(settings_.manifest.shared);
    if (settings_.part.is_one()) {
        refuse_other_whole_frames();
        settings_.folder = part_folder(settings_.part.number);
    }
    make_folder();
    lock_.emplace(settings_.folder);
    adopt_or_refuse();
}

void SequenceWriter::make_folder() const {
    std::error_code error;
    std::filesystem::create_directories(settings_.folder, error);
    if (error)
        throw InputError(expected_found(settings_.folder.string(), "a folder that can be made", error.message()));
    if (access(settings_.folder.c_str(), W_OK | X_OK) != 0)
        throw InputError(expected_found(settings_.folder.string(), "a writable folder", std::strerror(errno)));
}

/// Of one part: a frame that was put together counts as kept, so it must be of these settings.
void SequenceWriter::refuse_other_whole_frames() const {
    const std::filesystem::path& folder = settings_.folder;
    if (settings_.overwrite || !std::filesystem::exists(folder) || list_frames(folder).empty())
        return;
    if (const auto differs = difference(read_manifest(folder), settings_.manifest))
        throw InputError((folder / "manifest.json").string() + ": " + *differs +
                         "; choose another folder or overwrite");
}

/// A folder that holds frames of other settings is never added to: it is refused, or emptied of them on request.
void SequenceWriter::adopt_or_refuse() {
    const std::filesystem::path& folder = settings_.folder;
    const std::filesystem::path file = folder / "manifest.json";
    remove_unfinished_files(folder);
    const std::vector<std::int64_t> frames = list_frames(folder, extension());
    std::optional<std::string> refusal;
    if (std::filesystem::exists(file)) {
        try {
            const Manifest there = read_manifest(folder);
            if (const auto differs = difference(there, settings_.manifest))
                refusal = file.string() + ": " + *differs;
            else if (settings_.overwrite)
                set_first_frame(there.shared);
            else
                settings_.manifest = there;
        } catch (const InputError& problem) {
            refusal = problem.what();
        }
    } else if (!frames.empty()) {
        refusal = expected_found(file.string(), "a manifest beside the frames", "none");
    }
    if (refusal && !settings_.overwrite)
        throw InputError(*refusal + "; choose another folder or overwrite");
    knows_first_frame_ = !refusal && !frames.empty();
    manifest_is_current_ = knows_first_frame_ && !settings_.overwrite;
    if (refusal)
        outdated_ = frames;  // they stay until there is a frame to take their place
    else if (frames.empty())
        write_manifest(folder, settings_.manifest);
}

bool SequenceWriter::keeps_frame(std::int64_t index) const {
    std::filesystem::path file = frame_file(index);
    if (settings_.part.is_one()) {
        if (!settings_.overwrite && has_part(index))
            return true;
        file = settings_.folder.parent_path() / frame_file_name(index);
    }
    if (settings_.overwrite || index < 0 || !std::filesystem::exists(file))
        return false;
    try {
        require_whole_exr(file);
        return true;
    } catch (const InputError&) {
        return false;  // a disk that was full, or a copy that was cut
    }
}

void SequenceWriter::write(const Frame& frame, std::int64_t left_out_samples) {
    const std::filesystem::path file = frame_file(frame.info.index);
    require_readable(file.string(), frame.info);
    write_exr(file, frame,
              {.single_part = settings_.single_part,
               .left_out_samples = left_out_samples,
               .before_it_appears = [&] { make_way_for(frame.info); },
               .texts = settings_.texts});
}

/// Once the frame is written aside: only its renaming can fail then. Before that, so that a folder with frames always
/// says where its path begins.
void SequenceWriter::make_way_for(const FrameInfo& info) {
    for (; !outdated_.empty(); outdated_.pop_back())  // after a failure the next frame goes on here
        std::filesystem::remove(settings_.folder / frame_file_name(outdated_.back(), extension()));
    if (!knows_first_frame_ || info.index < settings_.manifest.shared.index) {
        set_first_frame(info);
        knows_first_frame_ = true;
        manifest_is_current_ = false;
    }
    if (!manifest_is_current_)
        write_manifest(settings_.folder, settings_.manifest);
    manifest_is_current_ = true;
}

void SequenceWriter::set_first_frame(const FrameInfo& first) {
    FrameInfo& shared = settings_.manifest.shared;
    shared.index = first.index;
    shared.time_s = first.time_s;
    shared.camera_pose = first.camera_pose;
    shared.head = first.head;
}

}  // namespace equistream
