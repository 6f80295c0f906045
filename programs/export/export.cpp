/// `equistream export`: rendered frames as EXR files that compositing programs read.
#include "compositing_exr.h"

#include <equistream/error.h>
#include <equistream/file_kind.h>
#include <equistream/json_text.h>
#include <equistream/locks.h>
#include <equistream/sequence.h>
#include <equistream/text.h>
#include <equistream/threads.h>
#include <programs/cli/frame_runs.h>
#include <programs/cli/paths.h>
#include <programs/cli/process.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>

#include <nlohmann/json.hpp>

#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <span>

namespace {

using namespace equistream;
namespace fs = std::filesystem;

struct Arguments {
    std::string command;
    fs::path folder, out;
    std::string layout = "deep", eye, progress = "auto";
    std::optional<cli::FrameRange> frames;
    bool overwrite = false, json = false;
};

/// One eye's frames.
struct Source {
    std::string name;
    fs::path folder;
    std::optional<fs::path> hidden;  ///< of main's eye alone
};

/// Those that the render has.
std::vector<Source> find_sources(const Arguments& a) {
    std::vector<Source> found;
    for (const char* eye : {"centre", "left", "right"})
        if ((a.eye.empty() || a.eye == eye) && holds_frames(a.folder / eye))
            found.push_back({eye, a.folder / eye, std::nullopt});
    if (found.empty() && a.eye.empty() && holds_frames(a.folder)) {
        const Eye eye = read_exr_info(a.folder / frame_file_name(list_frames(a.folder).front())).eye;
        found.push_back({eye_names[std::size_t(eye)], a.folder, std::nullopt});
    }
    cli::require(!found.empty(), a.folder.string(),
                 a.eye.empty() ? "frame.NNNN.exr files, here or in centre/, left/ or right/"
                               : "frame.NNNN.exr files in " + a.eye + "/",
                 "none");
    if (holds_frames(a.folder / "hidden"))
        found.front().hidden = a.folder / "hidden";
    return found;
}

/// Keeps the first. Returns the names of the others.
std::vector<std::string> leave_out_other_eyes(std::vector<Source>& sources) {
    std::vector<std::string> left_out;
    for (const Source& source : std::span(sources).subspan(1))
        left_out.push_back(source.name);
    sources.resize(1);
    return left_out;
}

std::vector<std::int64_t> chosen_frames(const Source& source, const Arguments& a) {
    std::vector<std::int64_t> frames = list_frames(source.folder);
    if (a.frames)
        std::erase_if(frames, [&](std::int64_t index) { return index < a.frames->first || index > a.frames->last; });
    cli::require(!frames.empty(), "--frames", "frames of " + source.folder.string(), "none in this range");
    const std::int64_t first = a.frames ? a.frames->first : frames.front();
    const std::int64_t last = a.frames ? a.frames->last : frames.back();
    const std::int64_t missing = cli::first_missing(frames, first);
    cli::require(!a.frames || missing > last, source.folder.string(),
                 "frames " + std::to_string(first) + "-" + std::to_string(last), "no " + frame_file_name(missing));
    if (missing <= last)
        std::fprintf(stderr, "equistream export: note: %s: frames are missing in between, the first is %lld\n",
                     source.folder.string().c_str(), static_cast<long long>(missing));
    return frames;
}

void require_new_frames(const Arguments& a, const std::vector<std::int64_t>& frames) {
    for (const std::int64_t index : frames) {
        const fs::path file = a.out / frame_file_name(index);
        cli::require(a.overwrite || !fs::exists(file), file.string(), "no file of this name, or --overwrite", "one");
    }
}

/// What is missing of another eye, or behind, is said before anything is written.
void require_same_frames(const fs::path& folder, const Source& first, const std::vector<std::int64_t>& frames) {
    for (const std::int64_t index : frames) {
        const fs::path file = folder / frame_file_name(index);
        cli::require(fs::exists(file), file.string(), "every frame of " + first.folder.string(), "no such file");
    }
}

Frame read_layer(const fs::path& file, bool depth_is_needed) {
    Frame frame = read_exr(file);
    cli::require(frame.planes.contains("colour"), file.string(), "channels R, G and B", "none");
    cli::require(!frame.info.patches && frame.info.window_columns == 0, file.string(), "a whole picture",
                 frame.info.patches ? "an atlas of patches" : "a window");
    cli::require(!depth_is_needed || frame.planes.contains("depth"), file.string(),
                 "plane depth, for the samples' places (render --aovs depth)", "none");
    return frame;
}

compositing::View read_view(const Source& source, std::int64_t index, bool deep) {
    const fs::path file = source.folder / frame_file_name(index);
    compositing::View view{source.name, file, read_layer(file, deep), std::nullopt};
    if (!source.hidden)
        return view;
    const fs::path behind = *source.hidden / frame_file_name(index);
    view.hidden = read_layer(behind, true);
    const FloatImage &front = view.front.planes.at("colour"), &hidden = view.hidden->planes.at("colour");
    const std::string size = size_text(front.width(), front.height());
    cli::require(front.width() == hidden.width() && front.height() == hidden.height(), behind.string(),
                 "the size of " + file.string() + ", " + size, size_text(hidden.width(), hidden.height()));
    require_companion(Companion::light, source.folder, view.front.info, *source.hidden, view.hidden->info,
                      ", or remove that folder");
    cli::require(view.front.info.eye == view.hidden->info.eye, behind.string(),
                 "hidden surfaces of the eye of " + file.string() + " (--eye says which is exported)", "another eye's");
    return view;
}

void run(const Arguments& a) {
    const cli::ProgressStyle style = cli::parse_progress(a.progress);
    const fs::file_type type = type_of(a.folder, "a folder of frames");
    cli::require(type == fs::file_type::directory, a.folder.string(), "a folder of frames",
                 type == fs::file_type::not_found ? "nothing" : "a file");
    const bool deep = a.layout == "deep";
    std::vector<Source> sources = find_sources(a);
    const std::vector<std::string> left_out = deep ? leave_out_other_eyes(sources) : std::vector<std::string>();
    // An eye's folder lies in that of a render, where other commands would take the files for the render's own.
    const fs::path full = fs::weakly_canonical(fs::absolute(a.folder));
    const bool is_eye = std::ranges::find(eye_names, full.filename().string()) != std::end(eye_names);
    cli::require_apart("--out", a.out, {is_eye ? full.parent_path() : a.folder});
    const std::vector<std::int64_t> frames = chosen_frames(sources.front(), a);
    for (const Source& source : sources) {
        require_same_frames(source.folder, sources.front(), frames);
        if (source.hidden)
            require_same_frames(*source.hidden, sources.front(), frames);
    }
    require_writable_folder(a.out);
    const FolderLock lock(a.out);
    require_new_frames(a, frames);
    Imf::setGlobalThreadCount(int(usable_processors()));
    compositing::DeepCounts counts;
    cli::note_interrupts();
    {
        cli::Progress progress("export", double(frames.size()), style);
        for (std::size_t i = 0; i < frames.size(); ++i) {
            std::vector<compositing::View> views;
            for (const Source& source : sources)
                views.push_back(read_view(source, frames[i], deep));
            const fs::path file = a.out / frame_file_name(frames[i]);
            if (deep) {
                const compositing::DeepCounts of_frame = compositing::write_deep(file, views.front());
                counts.front += of_frame.front;
                counts.hidden += of_frame.hidden;
                counts.left_out += of_frame.left_out;
            } else {
                compositing::write_parts(file, views);
            }
            progress.step(double(i + 1), "frame " + std::to_string(frames[i]));
            if (cli::interrupted() && i + 1 < frames.size())
                throw WorkError("interrupted: " + std::to_string(i + 1) + " of " + std::to_string(frames.size()) +
                                " frames are exported; to export the others, add --frames " +
                                std::to_string(frames[i + 1]) + "-" + std::to_string(frames.back()));
        }
    }
    const double pixels = double(counts.front);
    if (a.json) {
        nlohmann::ordered_json json = cli::provenance(a.command);
        json["out"] = a.out.string();
        json["layout"] = a.layout;
        json["frames"] = {{"first", frames.front()}, {"last", frames.back()}, {"count", frames.size()}};
        json["hidden"] = sources.front().hidden.has_value();
        json["eyes_left_out"] = left_out;
        if (deep)
            json["samples"] = {{"front", counts.front}, {"hidden", counts.hidden}, {"left_out", counts.left_out}};
        std::printf("%s\n", json_text(json, 2).c_str());
        return;
    }
    std::printf("%s: %zu frames, %s\n", a.out.string().c_str(), frames.size(), a.layout.c_str());
    if (deep)
        std::printf("  %.2f samples a pixel: the front surface, %s\n", (pixels + double(counts.hidden)) / pixels,
                    sources.front().hidden ? "and the hidden layer behind it"
                                           : "without what lies behind (render --layers adds it)");
    if (!left_out.empty())
        std::printf("  %s not exported: a deep file holds one eye (--eye chooses it; --layout parts holds both)\n",
                    in_a_sentence(left_out, " and ").c_str());
    if (counts.left_out > 0)
        std::printf("  %lld hidden samples did not lie behind the front surface and were dropped\n",
                    static_cast<long long>(counts.left_out));
}

std::function<void()> set_up(cli::CommandLine& app, Arguments& a) {
    app.add_option("DIR", a.folder, "A render's folder (centre/, left/, right/, hidden/), or one of these").required();
    app.add_option("--out", a.out, "Folder for the files, frame.NNNN.exr").required();
    cli::add_with_default(
        app, "--layout", a.layout,
        "deep: a deep EXR, the front surface and behind it the hidden one, Z and ZBack in metres along "
        "the ray; parts: an EXR of parts rgba, depth and hidden, with both eyes as views",
        {"deep", "parts"});
    app.add_option("--eye", a.eye, "Which folder: centre, left or right (deep: the first there is; parts: all)")
        .one_of({"centre", "left", "right"});
    cli::add_frames_option(app, a.frames, "FIRST-LAST or one number (default: all there are)");
    app.add_flag("--overwrite", a.overwrite, "Replace files that are there");
    cli::add_json_flag(app, a.json);
    cli::add_progress_option(app, a.progress);
    return [&a] { run(a); };
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    arguments.command = cli::quoted_command(argc, argv);
    return cli::run_program(argc, argv,
                            {"export", "Writes rendered frames as EXR files that compositing programs read",
                             "equistream export frames --out comp --layout deep"},
                            [&](cli::CommandLine& app) { return set_up(app, arguments); });
}
