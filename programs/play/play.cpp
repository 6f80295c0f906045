/// `equistream play`: what a headset's client does, into files and without a window.
#include "player.h"

#include <programs/cli/hdr_options.h>
#include <programs/cli/process.h>
#include <programs/cli/stage_names.h>

#include <equistream/error.h>
#include <equistream/file_kind.h>
#include <equistream/json_text.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>

namespace {

using namespace equistream;

struct Arguments {
    play::Settings settings;
    HdrOptions hdr;
    std::string model, size, progress = "auto", format = "png", layout = "files", anaglyph, mirrors = "images",
                             rechoose = "on";
    std::optional<cli::FrameRange> frames;
    double refresh_hz = 90;
};

using cli::require;

/// An option of earlier versions, which help does not list: it is taken with its value, and says that it does nothing.
void add_gone_option(cli::CommandLine& app, const std::string& name, const std::string& instead) {
    app.add_function(
           name,
           [name, instead](const std::string&) {
               std::fprintf(stderr, "equistream play: note: %s has no effect any more: %s\n", name.c_str(),
                            instead.c_str());
           },
           "")
        .group("");
}

/// Names of today for those of earlier versions.
void use_current_names(play::Settings& settings, const cli::CommandLine& app) {
    if (app.is_given("--method") && settings.method != "auto") {
        const EngineStage& engine = find_engine(settings.method, "--method", "auto");
        settings.method = current_name("play", "--method", engine, settings.method);
    }
    if (app.is_given("--depth"))
        settings.depth = current_name("play", "--depth", find_depth(settings.depth), settings.depth);
}

void choose_layout(Arguments& arguments, const cli::CommandLine& app) {
    play::Settings& settings = arguments.settings;
    const std::string& layout = arguments.layout;
    settings.layout = cli::parse_word<play::Layout>("--layout", layout, play::layout_names);
    if (settings.layout == play::Layout::anaglyph)
        settings.anaglyph = &(app.is_given("--anaglyph") ? find_anaglyph(arguments.anaglyph) : anaglyphs().front());
    else
        require(!app.is_given("--anaglyph"), "--anaglyph", "--layout anaglyph as well", layout);
    require(settings.layout == play::Layout::files || settings.format != play::Format::exr, "--layout",
            "files for --format exr, which keeps each eye's camera", layout);
}

/// Containers whose name as --out makes it the video of both eyes, as encode's names do.
constexpr std::array video_extensions = {".mp4", ".mkv"};

/// Nobody means a folder by these.
constexpr std::array other_extensions = {".mov",  ".webm", ".avi", ".m4v", ".ts",   ".nut", ".h264",
                                         ".h265", ".gif",  ".png", ".jpg", ".jpeg", ".exr"};

/// `--out eyes.mp4` is that file, unless a folder of this name is there already. It holds both eyes: side by side, or
/// as --layout says.
void choose_video(Arguments& arguments, const cli::CommandLine& app) {
    play::Settings& settings = arguments.settings;
    const std::filesystem::path& out = settings.out;
    std::string extension = out.extension().string();
    for (char& c : extension)
        c = char(std::tolower(static_cast<unsigned char>(c)));
    const std::string option = "--out " + out.string();
    require(std::ranges::find(other_extensions, extension) == other_extensions.end(), option,
            "a folder, or NAME.mp4 or NAME.mkv", "the name of another file");
    if (std::ranges::find(video_extensions, extension) == video_extensions.end())
        return;
    require(type_of(out, "the name of a video") != std::filesystem::file_type::directory, option, "the name of a video",
            "a folder of this name");
    settings.out_is_video = true;
    if (!app.is_given("--layout"))
        arguments.layout = app.is_given("--anaglyph") ? "anaglyph" : "sbs";
    require(arguments.layout != "files", option, "--layout sbs or anaglyph, both eyes in one video", "--layout files");
    if (!app.is_given("--format"))
        arguments.format = "mp4";
    require(arguments.format == "mp4", option, "--format mp4, or the name of a folder", "--format " + arguments.format);
    require(!settings.reliability, option, "the name of a folder for --reliability", "the name of a video");
}

constexpr double longest_extrapolation_s = 1;
constexpr const char* former_extrapolate = "--carry";

void choose_refreshes(Arguments& arguments, const cli::CommandLine& app) {
    play::Settings& settings = arguments.settings;
    settings.conditions = parse_network(settings.network, "--network");
    if (!app.is_given("--refresh") && !app.is_given("--network")) {
        for (const char* option : {"--extrapolate", former_extrapolate})
            require(!app.is_given(option), option, "--refresh or --network as well", "neither");
        return;
    }
    require(arguments.refresh_hz >= 1 && arguments.refresh_hz <= 1000, "--refresh", "1 to 1000 Hz",
            in_words(arguments.refresh_hz));
    require(!settings.head.empty(), app.is_given("--refresh") ? "--refresh" : "--network",
            "--head CSV as well: the head moves on while frames are late", "none");
    settings.refresh_hz = arguments.refresh_hz;
    require(settings.extrapolation_limit_s >= 0 && settings.extrapolation_limit_s <= longest_extrapolation_s,
            "--extrapolate", "0 to 1 s", in_words(settings.extrapolation_limit_s));
}

void complete(Arguments& arguments, const cli::CommandLine& app) {
    play::Settings& settings = arguments.settings;
    choose_video(arguments, app);
    settings.format = cli::parse_word<play::Format>("--format", arguments.format, play::format_names);
    settings.progress = cli::parse_progress(arguments.progress);
    choose_layout(arguments, app);
    choose_refreshes(arguments, app);
    use_current_names(settings, app);
    const bool by_budget = settings.method == "auto";
    for (const char* option : {"--budget-ms", "--rechoose"})
        require(by_budget || !app.is_given(option), option, "--method auto as well",
                settings.method.empty() ? "none" : settings.method);
    require(!by_budget || (settings.budget_ms > 0 && settings.budget_ms <= 1e6), "--budget-ms",
            "milliseconds a frame, above 0, for --method auto", in_words(settings.budget_ms));
    settings.rechoose = cli::parse_word("--rechoose", arguments.rechoose, std::array{"on", "off"}) == 0;
    parse_fills(settings.fill);
    settings.hdr_display = arguments.hdr.display();
    require(settings.format != play::Format::exr || !settings.hdr_display, "--format exr",
            "no --display, --view-transform, --exposure or --ocio, as EXR keeps linear light", "one of them");
    settings.mirrors = find_mirror_treatment(arguments.mirrors);
    settings.scene_is_model = !arguments.model.empty();
    if (settings.scene_is_model)
        settings.scene = arguments.model;
    if (app.is_given("--size"))
        settings.size = cli::parse_size(arguments.size);
    if (arguments.frames)
        settings.frames = *arguments.frames;
    if (const auto& deg = settings.fov_deg)
        require(*deg > 0.1 && *deg < 179, "--fov", "degrees above 0.1 and below 179", in_words(*deg));
    if (const auto& ipd_m = settings.ipd_m)
        require(*ipd_m >= 0 && *ipd_m <= 1, "--ipd", "metres from 0 to 1", std::to_string(*ipd_m));
    require(settings.repeat >= 1 && settings.repeat <= 10000, "--repeat", "1 to 10000",
            std::to_string(settings.repeat));
}

void run(Arguments& arguments, const cli::CommandLine& app) {
    cli::hide_secret(arguments.settings.source);
    complete(arguments, app);
    cli::say_at_interrupt("equistream play: interrupted before the first frame was played");
    const play::Report report = play::play(arguments.settings);
    if (arguments.settings.json)
        std::puts(json_text(report.json(), 1).c_str());
    else
        std::fputs(report.table().c_str(), stdout);
    if (!report.truncation.empty())
        throw WorkError(report.truncation);
}

std::function<void()> set_up(cli::CommandLine& app, const std::string& command) {
    auto arguments = std::make_shared<Arguments>();
    play::Settings& settings = arguments->settings;
    settings.command = command;
    app.add_option("source", settings.source, "A stream (file or URL), or a folder of rendered frames").required();
    cli::Option scene = app.add_option("--scene", settings.scene, "Scene description whose geometry gives depth");
    app.add_option("--model", arguments->model, "The same by the client's model of it (equistream model)")
        .excludes(scene);
    app.add_option("--head", settings.head,
                   "CSV of head poses; default: the pose in each picture. A server gets these poses too: a live one "
                   "renders each frame for where the head will be");
    std::vector<std::string_view> methods = names_of(engine_stages());
    methods.emplace_back("auto");
    app.add_option("--method", settings.method,
                   "How the eyes' pictures are made. Default: eye-depth where the eyes' depth is known, mesh where the "
                   "source's alone is, else rotation" +
                       described(engine_stages()) + "\nauto          what --budget-ms allows")
        .offers(methods);
    app.add_option("--budget-ms", settings.budget_ms,
                   "For --method auto: milliseconds a frame, both eyes, from decoding to filling. The most accurate "
                   "method that fits on this machine is found on one of the first frames");
    cli::add_with_default(app, "--rechoose", arguments->rechoose,
                          "For --method auto. on: change to a cheaper method when frames take longer than --budget-ms, "
                          "and back when there is time. off: keep the first choice")
        .offers(std::array{"on", "off"});
    app.add_option("--depth", settings.depth,
                   "Where depth comes from. Default: ray with a scene, else the source's own depth, else none" +
                       described(depth_stages()))
        .offers(depth_stages());
    add_gone_option(app, "--depth-reuse", "all rays of a sphere are cast in each frame");
    app.add_option("--size", arguments->size, "WxH of each eye; default: a perspective source's own, else 1280x720");
    app.add_option("--fov", settings.fov_deg, "Horizontal, degrees; default: a perspective source's own, else 90");
    app.add_option("--ipd", settings.ipd_m, "Metres between the eyes; default: as tagged");
    cli::add_with_default(
        app, "--fill", settings.fill,
        "Passes that fill gaps, in order, separated by commas; or none. A pass without data is skipped" +
            described(fill_stages()));
    cli::add_with_default(app, "--mirrors", arguments->mirrors,
                          "How mirrors and glass are shown, where the source holds data of their reflections\n"
                          "images        at the depth of their virtual image\n"
                          "gaps          left as gaps, for --fill\n"
                          "surface       as if painted on the surface")
        .offers(mirror_treatment_names());
    app.add_flag("--reliability", settings.reliability,
                 "Write how far each pixel can be trusted: reliability/left and right, 255 times a probability");
    arguments->hdr.add_to(app);
    cli::add_with_default(app, "--layout", arguments->layout,
                          "files: left and right; sbs: both eyes side by side; anaglyph: for red and cyan glasses")
        .offers(play::layout_names);
    app.add_option("--anaglyph", arguments->anaglyph, "Colours for red and cyan glasses (default: dubois)")
        .offers(anaglyphs());
    cli::add_with_default(app, "--format", arguments->format,
                          "Of the pictures; exr: linear, scene-referred, up to white")
        .offers(play::format_names);
    cli::add_frames_option(app, arguments->frames, "FIRST-LAST or one number; default: all");
    cli::add_with_default(app, "--repeat", settings.repeat, "Time depth, reprojection and fill this often a frame");
    app.add_option(
        "--refresh", arguments->refresh_hz,
        "Write one picture for each refresh of a display of this rate, in Hz. It shows the frames that have arrived by "
        "then from the predicted head pose. Default: 90 with --network, else one picture a frame");
    app.add_option("--network", settings.network, "How late frames come, KEY=VALUE,...\n" + network_help());
    cli::add_former_name(app, "play", former_extrapolate, "--extrapolate", settings.extrapolation_limit_s);
    cli::add_with_default(
        app, "--extrapolate", settings.extrapolation_limit_s,
        "With --refresh: seconds, at most, by which moving objects are extrapolated while frames are late. 0: they "
        "stay where frames show them. The stream must hold their motion (encode --motion)");
    cli::add_json_flag(app, settings.json);
    cli::add_progress_option(app, arguments->progress);
    app.add_option("--out", settings.out,
                   "Folder for left/, right/, gaps/ and report.json; or NAME.mp4 or NAME.mkv: one video of both eyes, "
                   "side by side or by --layout anaglyph")
        .required();
    app.add_flag("--overwrite", settings.overwrite,
                 "Replace views of other settings in the folder, or a video of this name; default: both are refused");
    return [arguments, &app] { run(*arguments, app); };
}

}  // namespace

int main(int argc, char** argv) {
    const std::string command = cli::quoted_command(argc, argv);
    return cli::run_program(argc, argv,
                            {"play", "Turns a stream into what each eye sees, without a window",
                             "equistream play walk.mp4 --scene scenes/pavilion.json --size 1280x720 --out eyes"},
                            [&](cli::CommandLine& app) { return set_up(app, command); });
}
