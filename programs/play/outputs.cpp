#include "outputs.h"

#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/locks.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>
#include <programs/cli/paths.h>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace equistream::play {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path report_in(const fs::path& out) {
    return out / "report.json";
}

/// What was not asked for.
bool is_default(const Json& setting) {
    return setting.is_null() || setting == "";
}

/// Pictures and videos of any run in this folder, whatever its settings.
std::vector<fs::path> views_in(const fs::path& out) {
    std::vector<fs::path> views;
    std::error_code error;
    for (const fs::path& folder : {out / "left", out / "right", out / "both", out / "gaps" / "left",
                                   out / "gaps" / "right", out / "reliability" / "left", out / "reliability" / "right"})
        for (const char* extension : {"png", "exr"})
            if (fs::is_directory(folder, error))
                for (const std::int64_t index : list_frames(folder, extension))
                    views.push_back(folder / frame_file_name(index, extension));
    for (const char* file : {"left.mp4", "right.mp4", "both.mp4"})
        if (fs::exists(out / file, error))
            views.push_back(out / file);
    return views;
}

/// Views of other settings stay, unless they may be overwritten: the report beside them says what theirs were.
void require_own_views(const Settings& settings, const std::vector<fs::path>& views) {
    if (settings.overwrite)
        return;
    const fs::path file = report_in(settings.out);
    const auto refuse = [](const fs::path& place, const std::string& expected, const std::string& found) {
        throw InputError(expected_found(place.string(), expected, found) + "; choose another folder or --overwrite");
    };
    if (!fs::exists(file)) {
        if (!views.empty())
            refuse(settings.out, "a report.json with the settings of its views",
                   views.front().string() + " without one");
        return;
    }
    std::ifstream text(file);
    const Json report = Json::parse(text, nullptr, false);
    if (!report.is_object() || !report.contains("settings") || !report["settings"].is_object())
        refuse(file, "the report of play", "another file");
    const Json now = settings_json(settings);
    for (const auto& [name, before] : report["settings"].items())
        if (name != "repeat" && now.contains(name) && json_text(now[name]) != json_text(before))
            refuse(file,
                   is_default(before) ? "the default " + name + " as of the views there"
                                      : name + " " + json_text(before) + " as of the views there",
                   is_default(now[name]) ? "the default" : json_text(now[name]));
}

/// What is played is neither overwritten nor removed.
void require_source_elsewhere(const Settings& settings) {
    std::vector<fs::path> targets{settings.out};
    if (settings.out_is_video)
        targets.push_back(settings.out.string() + ".part");
    else
        for (const char* view : {"left", "right", "both", "left.mp4", "right.mp4", "both.mp4"})
            targets.push_back(settings.out / view);
    for (const fs::path& target : targets)
        cli::require_not_read("--out", target, {settings.source});
}

/// A video does not say which settings it is of: as with export, none makes way unasked.
void require_new_video(const Settings& settings) {
    std::error_code error;
    cli::require(settings.overwrite || !fs::is_regular_file(settings.out, error), "--out " + settings.out.string(),
                 "the name of a new video, or --overwrite", "a file of this name");
}

/// It is locked from its first picture on. A run that begins later than that is told before it plays.
void require_unlocked_video(const Settings& settings) {
    const fs::path aside = settings.out.string() + ".part";
    const int file = open_locked_file(aside, IfMissing::fail);
    const bool is_locked = file < 0 && errno == EWOULDBLOCK;
    cli::require(!is_locked, "--out " + settings.out.string(), "a file that no other process is writing",
                 aside.string() + ", which another process is writing");
    if (file >= 0)
        close(file);
}

/// Views of an earlier run make way, so that a folder never holds a mixture; rendered frames are never touched.
void clear_views(const Settings& settings) {
    const fs::path& out = settings.out;
    for (const char* view : {".", "centre", "small", "left", "right"})
        if (const fs::path manifest = (out / view / "manifest.json").lexically_normal(); fs::exists(manifest))
            throw InputError(
                expected_found("--out " + out.string(), "a folder without rendered frames", manifest.string()));
    const std::vector<fs::path> views = views_in(out);
    require_own_views(settings, views);
    for (const fs::path& view : views)
        fs::remove(view);
    fs::remove(report_in(out));
}

}  // namespace

Outputs::Outputs(const Settings& settings) : out_(settings.out), is_video_(settings.out_is_video) {
    require_source_elsewhere(settings);
    if (is_video_) {
        require_unlocked_video(settings);
        require_new_video(settings);
    } else {
        prepare_folder(settings);
    }
    eyes_.emplace(settings);
}

/// A run that is killed leaves a report of its settings, so that the same command makes its views anew.
void Outputs::prepare_folder(const Settings& settings) {
    require_writable_folder(out_);
    lock_.emplace(out_);
    clear_views(settings);
    for (const char* eye : {"left", "right"}) {
        require_writable_folder(out_ / "gaps" / eye);
        if (settings.reliability)
            require_writable_folder(out_ / "reliability" / eye);
    }
    write_file_atomically(report_in(out_), json_text(begun_report_json(settings), 1) + "\n");
}

void Outputs::write(const PlayedFrame& frame) {
    eyes_->write({frame.left.picture, frame.left.depth_view(), frame.left.info},
                 {frame.right.picture, frame.right.depth_view(), frame.right.info});
    if (is_video_)
        return;
    const std::string name = frame_file_name(frame.left.info.index, "png");
    for (const auto& [eye, played] : {std::pair{"left", &frame.left}, {"right", &frame.right}}) {
        write_picture(out_ / "gaps" / eye / name, played->gaps.view());
        if (!played->picture.reliability.empty())
            write_picture(out_ / "reliability" / eye / name, played->picture.reliability.view());
    }
}

void Outputs::write_report(const Report& report) const {
    if (!is_video_)
        write_file_atomically(report_in(out_), json_text(report.json(), 1) + "\n");
}

}  // namespace equistream::play
