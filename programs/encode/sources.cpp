#include "sources.h"

#include <programs/cli/frame_runs.h>

#include <equistream/error.h>
#include <equistream/file_kind.h>
#include <equistream/sequence.h>
#include <equistream/text.h>

#include <algorithm>

namespace equistream {

namespace {

namespace fs = std::filesystem;

constexpr TrackRole fill_roles[] = {TrackRole::small, TrackRole::hidden, TrackRole::patches};
constexpr const char* eyes_by_preference[] = {"centre", "left", "right"};

std::string what_is_in(const fs::path& folder) {
    std::string names;
    for (const auto& entry : fs::directory_iterator(folder))
        names += (names.empty() ? "" : ", ") + entry.path().filename().string();
    return names.empty() ? "an empty folder" : names.size() > 200 ? names.substr(0, 200) + " ..." : names;
}

fs::path main_folder(const SourceRequest& request) {
    if (request.eye) {
        fs::path folder = request.folder / *request.eye;
        cli::require(holds_frames(folder), folder.string(), "frame.NNNN.exr files", "none");
        return folder;
    }
    if (holds_frames(request.folder))
        return request.folder;
    for (const char* eye : eyes_by_preference)
        if (holds_frames(request.folder / eye))
            return request.folder / eye;
    throw InputError(expected_found(request.folder.string(),
                                    "frame.NNNN.exr files, here or in centre/, left/ or right/",
                                    what_is_in(request.folder)));
}

/// Folders are called as their tracks are. Beside the main folder; for a single eye's folder only when asked for.
std::optional<fs::path> find_fill_folder(const SourceRequest& request, const fs::path& main, TrackRole role) {
    const bool given_directly = main == request.folder;
    const fs::path parent = given_directly ? fs::weakly_canonical(main).parent_path() : request.folder;
    const fs::path folder = parent / track_name(role);
    if (request.fill.automatic)
        return given_directly || !holds_frames(folder) ? std::nullopt : std::optional(folder);
    if (std::ranges::find(request.fill.roles, role) == request.fill.roles.end())
        return std::nullopt;
    cli::require(holds_frames(folder), folder.string(),
                 "the " + std::string(track_name(role)) + " stream's frame.NNNN.exr files", "none");
    return folder;
}

std::vector<std::int64_t> chosen_frames(const fs::path& folder, const std::optional<cli::FrameRange>& range) {
    const std::vector<std::int64_t> present = list_frames(folder);
    const std::int64_t first = range ? range->first : present.front();
    const std::int64_t last = range ? range->last : present.back();
    // Checked before counting: a range is only as long as there are frames for it.
    std::vector<std::int64_t> frames;
    for (const std::int64_t index : present)
        if (index >= first && index <= last)
            frames.push_back(index);
    const std::int64_t expected = cli::first_missing(frames, first);
    cli::require(expected == last + 1, folder.string(), "frames " + std::to_string(first) + "-" + std::to_string(last),
                 "no " + frame_file_name(expected) + " (render it, or choose --frames)");
    return frames;
}

Sources find_both_eyes(const SourceRequest& request) {
    Sources sources;
    sources.packing = request.packing;
    for (const char* eye : {"left", "right"})
        cli::require(holds_frames(request.folder / eye), (request.folder / eye).string(),
                     "frame.NNNN.exr files of that eye (render --eye both)", "none");
    sources.tracks.push_back({TrackRole::main, request.folder / "left"});
    sources.right_eye = request.folder / "right";
    sources.frames = chosen_frames(sources.tracks.front().folder, request.frames);
    chosen_frames(sources.right_eye, cli::FrameRange{sources.frames.front(), sources.frames.back()});
    return sources;
}

}  // namespace

FillTracks parse_fill_tracks(const std::string& list) {
    if (list == "auto")
        return {};
    FillTracks tracks{false, {}};
    if (list == "none")
        return tracks;
    for (const std::string_view word : split_at_commas(list)) {
        const auto role =
            std::ranges::find_if(fill_roles, [&](TrackRole candidate) { return word == track_name(candidate); });
        cli::require(role != std::end(fill_roles), "--fill",
                     "auto, none, or some of small, hidden, patches with commas between",
                     "'" + std::string(word) + "'");
        tracks.roles.push_back(*role);
    }
    return tracks;
}

const SourceTrack& Sources::looked_at() const {
    const auto window = std::ranges::find(tracks, TrackRole::window, &SourceTrack::role);
    return window != tracks.end() ? *window : tracks.front();
}

Sources find_sources(const SourceRequest& request) {
    const fs::file_type type = type_of(request.folder, "a folder of frames");
    if (type != fs::file_type::directory)
        throw InputError(
            expected_found(request.folder.string(), "a folder of frames",
                           type == fs::file_type::not_found ? "nothing" : found_kind(request.folder, "a file")));
    if (request.packing != StereoPacking::none)
        return find_both_eyes(request);
    Sources sources;
    const fs::path main = main_folder(request);
    sources.tracks.push_back({TrackRole::main, main});
    sources.frames = chosen_frames(main, request.frames);
    for (const char* eye : eyes_by_preference)
        if (main != request.folder && main != request.folder / eye && holds_frames(request.folder / eye))
            sources.left_out.emplace_back(eye);
    if (const fs::path window = request.folder / track_name(TrackRole::window);
        main != request.folder && holds_frames(window))
        sources.tracks.push_back({TrackRole::window, window});
    for (const TrackRole role : fill_roles)
        if (const auto folder = find_fill_folder(request, main, role))
            sources.tracks.push_back({role, *folder});
    for (const SourceTrack& track : sources.tracks)
        chosen_frames(track.folder, cli::FrameRange{sources.frames.front(), sources.frames.back()});
    return sources;
}

}  // namespace equistream
