#include "sequence.h"

#include "guard.h"
#include "handles.h"

#include <unistd.h>

#include <cerrno>
#include <utility>

namespace equistream {

Sequence::Sequence(SequenceSettings settings) : settings_(std::move(settings)) {
    make_folder();
    lock_.emplace(settings_.folder);
    adopt_or_refuse();
}

void Sequence::make_folder() const {
    std::error_code error;
    std::filesystem::create_directories(settings_.folder, error);
    if (error)
        throw InputError(
            expected_found("output_dir " + settings_.folder.string(), "a folder that can be made", error.message()));
    if (access(settings_.folder.c_str(), W_OK | X_OK) != 0)
        throw InputError(
            expected_found("output_dir " + settings_.folder.string(), "a writable folder", std::strerror(errno)));
}

/// A folder that holds frames of other settings is never added to: it is refused, or emptied of them on request.
void Sequence::adopt_or_refuse() {
    const std::filesystem::path& folder = settings_.folder;
    const std::filesystem::path file = folder / "manifest.json";
    remove_unfinished_files(folder);
    const std::vector<std::int64_t> frames = list_frames(folder);
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

bool Sequence::keeps_frame(std::int64_t index) const {
    return !settings_.overwrite && index >= 0 && std::filesystem::exists(settings_.folder / frame_file_name(index));
}

void Sequence::write(const Frame& frame, std::int64_t left_out_samples) {
    make_way_for(frame.info);
    write_exr(settings_.folder / frame_file_name(frame.info.index), frame,
              {.single_part = settings_.single_part, .left_out_samples = left_out_samples});
}

/// Before the frame appears, so that a folder with frames always says where its path begins.
void Sequence::make_way_for(const FrameInfo& info) {
    for (const std::int64_t index : std::exchange(outdated_, {}))
        std::filesystem::remove(settings_.folder / frame_file_name(index));
    if (!knows_first_frame_ || info.index < settings_.manifest.shared.index) {
        set_first_frame(info);
        knows_first_frame_ = true;
        manifest_is_current_ = false;
    }
    if (!manifest_is_current_)
        write_manifest(settings_.folder, settings_.manifest);
    manifest_is_current_ = true;
}

void Sequence::set_first_frame(const FrameInfo& first) {
    FrameInfo& shared = settings_.manifest.shared;
    shared.index = first.index;
    shared.time_s = first.time_s;
    shared.camera_pose = first.camera_pose;
    shared.head = first.head;
}

}  // namespace equistream

using namespace equistream;

extern "C" {

uint32_t es_abi_version(void) {
    return ES_ABI_VERSION;
}

const char* es_version(void) {
    return EQUISTREAM_VERSION;
}

es_status es_sequence_open(const es_sequence_settings* settings, es_sequence** sequence, es_error* error) {
    if (sequence != nullptr)
        *sequence = nullptr;
    return guarded(error, [&] {
        if (sequence == nullptr)
            throw InputError(expected_found("es_sequence_open: sequence", "a pointer", "NULL"));
        *sequence = new es_sequence{std::make_shared<Sequence>(checked_settings(settings))};
    });
}

int es_sequence_has_frame(const es_sequence* sequence, int64_t index) {
    bool kept = false;
    if (sequence != nullptr)
        guarded(nullptr, [&] { kept = sequence->shared->keeps_frame(index); });
    return kept;
}

void es_sequence_close(es_sequence* sequence) {
    delete sequence;
}

}  // extern "C"
