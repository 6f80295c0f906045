#include "truncation.h"

namespace equistream {

namespace {

std::string pictures(std::int64_t count) {
    return std::to_string(count) + (count == 1 ? " picture" : " pictures");
}

std::string describe(const TrackTally& track) {
    const std::string name = track_name(track.role);
    const std::string of = track.count > 0 ? " of " + std::to_string(track.count) : "";
    std::string text;
    if (track.count == 0 || track.expected < track.count)
        text = name + " was cut after frame " + std::to_string(*track.last_index) + " (" +
               std::to_string(track.pictures) + of + (track.count > 0 ? " pictures play)" : " play)");
    if (track.missing > 0)
        text += text.empty() ? name + " lacks " + pictures(track.missing)
                             : " and lacks " + pictures(track.missing) + " before that";
    return text;
}

std::string describe_foreign(const SourceEnd& end, const TrackTally& track) {
    if (track.pictures == 0)
        return "was cut before its first picture, or is damaged";
    const std::string played = pictures(track.pictures);
    if (!end.read_error.empty())
        return "was cut or damaged after " + played + " (" + end.read_error + ")";
    if (!track.jumped && end.announced_pictures > track.pictures + track.missing)
        return "was cut after " + played + " of " + std::to_string(end.announced_pictures);
    if (end.missing_bytes > 0)
        return "was cut: its last " + std::to_string(end.missing_bytes) + " bytes are missing";
    if (track.unreadable > 0)
        return "is damaged: " + pictures(track.unreadable) + " could not be decoded, " +
               std::to_string(track.pictures) + " play";
    return "";
}

}  // namespace

std::string describe_truncation(const SourceEnd& end, std::span<const TrackTally> tracks) {
    bool ours = false;
    for (const TrackTally& track : tracks)
        ours = ours || track.ours;
    if (!ours) {
        const std::string text = tracks.empty() ? "" : describe_foreign(end, tracks.front());
        return text.empty() ? "" : end.source + " " + text;
    }
    std::string text;
    for (const TrackTally& track : tracks) {
        if (track.whole())
            continue;
        const std::string part =
            track.ours ? describe(track) : std::string(track_name(track.role)) + " was cut before its first picture";
        text += (text.empty() ? "" : "; ") + part;
    }
    return text.empty() ? "" : end.source + ": " + text;
}

}  // namespace equistream
