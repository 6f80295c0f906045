/// `equistream view`: a stream in a window, seen from wherever the viewer's head is.
#include <client/stages/stages.h>
#include <client/view/viewer.h>
#include <client/view/xr/headset.h>
#include <programs/cli/hdr_options.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>

#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/text.h>

#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace {

using namespace equistream;

struct Arguments {
    std::string command;
    ViewerSettings settings;
    HdrOptions hdr;
    std::filesystem::path scene, model;
    std::string size, decode = "auto", upload = "auto", predict = "auto";
    std::map<std::string_view, std::string> words;  ///< of shown_settings(), by their names
    std::map<std::string_view, bool> flags;         ///< the same
    double fov_deg = default_view_fov_deg;
    bool keys = false, json = false, no_config = false;
};

template <typename Value, typename Words>
Value parse_word(const char* option, const std::string& word, const Words& words) {
    return cli::parse_word<Value>(option, word, words, ", ");
}

constexpr std::array decoders = {"software", "auto"};
/// As PictureUpload has them.
constexpr std::array uploads = {"auto", "mapped", "copied"};

/// HeadPredictor looks no further ahead.
constexpr double max_predicted_ms = 150;

std::optional<double> parse_prediction(const std::string& text) {
    if (text == "auto")
        return std::nullopt;
    if (text == "off")
        return 0.0;
    const std::optional<double> ms = parsed_number(text);
    cli::require(ms >= 0.0 && ms <= max_predicted_ms, "--predict",
                 "auto, off or milliseconds from 0 to " + in_words(max_predicted_ms), "'" + text + "'");
    return 1e-3 * *ms;
}

void note(const std::string& words) {
    std::fprintf(stderr, "equistream view: note: %s\n", words.c_str());
}

/// As play: unless told otherwise by the eye's own depth where geometry gives it, else by the stream's.
void require_depth_for_method(const Arguments& arguments, const cli::CommandLine& app) {
    if (!app.is_given("--method"))
        return;
    const EngineStage& engine = find_engine(arguments.words.at("method"));
    const std::string method(engine.name);
    const std::string geometry = app.is_given("--scene")   ? "--scene " + arguments.scene.string()
                                 : app.is_given("--model") ? "--model " + arguments.model.string()
                                                           : "";
    cli::require(!engine.on_gpu || !engine.finds_depth || geometry.empty(), "--method " + method,
                 "no --scene or --model (--method eye-depth uses them)", geometry);
    cli::require(!engine.needs.eye || !geometry.empty(), "--method " + method,
                 "--scene S or --model M, for the eyes' own depth (--method mesh needs neither)", "neither");
}

/// What was kept, unless the command line says otherwise.
void choose_what_is_shown(Arguments& arguments, const cli::CommandLine& app) {
    ViewerSettings& settings = arguments.settings;
    settings.kept_in = arguments.no_config ? std::filesystem::path() : kept_settings_file();
    if (!settings.kept_in.empty()) {
        ReadSettings read = read_kept_settings(settings.kept_in);
        if (!read.note.empty())
            note(read.note);
        if (!read.may_be_written)
            settings.kept_in.clear();
        settings.kept = std::move(read.kept);
        settings.kept.apply_to(settings.shown);
    }
    settings.shown.by_geometry = app.is_given("--scene") || app.is_given("--model");
    require_depth_for_method(arguments, app);
    for (const ShownSetting& setting : shown_settings()) {
        if (setting.option == SettingOption::none || !app.is_given("--" + std::string(setting.name)))
            continue;
        const std::string word = setting.option == SettingOption::word ? arguments.words.at(setting.name)
                                 : arguments.flags.at(setting.name)    ? "on"
                                                                       : "off";
        for (const std::string& words : setting.set(settings.shown, word))
            note(words);
    }
    settings.hdr_display = arguments.hdr.display();
    if (settings.hdr_display)
        settings.shown.exposure_stops = settings.hdr_display->settings().exposure_stops;
}

void complete(Arguments& arguments, const cli::CommandLine& app) {
    ViewerSettings& settings = arguments.settings;
    cli::require(!settings.source.empty() || !settings.headset, "--headset", "a stream or a folder to show", "none");
    choose_what_is_shown(arguments, app);
    settings.hardware = parse_word<int>("--decode", arguments.decode, decoders) == 1;
    settings.upload = parse_word<PictureUpload>("--upload", arguments.upload, uploads);
    settings.predict_s = parse_prediction(arguments.predict);
    if (app.is_given("--size")) {
        const cli::Size size = cli::parse_size(arguments.size);
        settings.size = {size.width, size.height};
    }
    cli::require(arguments.fov_deg >= 10 && arguments.fov_deg <= 150, "--fov", "degrees from 10 to 150",
                 in_words(arguments.fov_deg));
    if (app.is_given("--fov"))
        settings.fov_deg = arguments.fov_deg;
    if (const auto& ipd_m = settings.ipd_m)
        cli::require(*ipd_m >= 0 && *ipd_m <= 1, "--ipd", "metres from 0 to 1", in_words(*ipd_m));
    cli::require(settings.extrapolation_limit_s >= 0 && settings.extrapolation_limit_s <= 1, "--extrapolate",
                 "0 to 1 s", in_words(settings.extrapolation_limit_s));
    cli::require(settings.seconds >= 0, "--seconds", "0 or more", in_words(settings.seconds));
    if (const std::filesystem::path& scene = arguments.model.empty() ? arguments.scene : arguments.model;
        !scene.empty())
        settings.scene = load_scene(scene);
}

nlohmann::ordered_json json_of(const ViewerReport& report, const std::string& command) {
    nlohmann::ordered_json json = cli::provenance(command);
    json["seconds"] = report.seconds;
    json["refreshes"] = report.refreshes;
    json["frames"] = report.frames;
    json["moved_on_ms"] = 1e3 * report.extrapolation_s;
    json["truth_psnr_db"] = cli::or_null(report.truth_db);
    json["latency_ms"] = 1e3 * report.latency_s;
    json["playout_delay_ms"] = nullptr;
    if (report.playout_delay_s)
        json["playout_delay_ms"] = 1e3 * *report.playout_delay_s;
    json["decoder"] = nullptr;
    if (!report.decoder.empty())
        json["decoder"] = report.decoder;
    json["decode_ms"] = report.decode_ms;
    json["mapped_bytes"] = report.mapped_bytes;
    json["stages_ms"] = nullptr;
    for (std::size_t stage = 0; report.stages_ms && stage < report.stages_ms->size(); ++stage)
        json["stages_ms"][std::string(gl::render_stage_names[stage])] = (*report.stages_ms)[stage];
    for (const Fact& fact : report.facts)
        json["panel"][std::string(panel_section_names[std::size_t(fact.section)])][std::string(fact.label)] =
            fact.value;
    return json;
}

void run(Arguments& arguments, const cli::CommandLine& app) {
    if (arguments.keys) {
        std::fputs(key_help().c_str(), stdout);
        return;
    }
    cli::hide_secret(arguments.settings.source);
    complete(arguments, app);
    Viewer viewer(arguments.settings);
    const ViewerReport report = viewer.run();
    if (arguments.json)
        std::printf("%s\n", json_text(json_of(report, arguments.command), 2).c_str());
}

void add_shown_settings(cli::CommandLine& app, Arguments& arguments) {
    for (const ShownSetting& setting : shown_settings()) {
        const std::string option = "--" + std::string(setting.name);
        if (setting.option == SettingOption::flag)
            app.add_flag(option, arguments.flags[setting.name], setting.help);
        if (setting.option != SettingOption::word)
            continue;
        std::string& word = arguments.words[setting.name];
        word = setting.has_default ? setting.value({}) : "";
        cli::Option added = app.add_option(option, word, setting.help);
        if (setting.has_default)
            added = added.with_default();
        if (setting.parts.empty())
            added.offers(setting.words);
    }
}

std::function<void()> set_up(cli::CommandLine& app, const std::string& command) {
    auto arguments = std::make_shared<Arguments>();
    arguments->command = command;
    ViewerSettings& settings = arguments->settings;
    app.add_option("source", settings.source,
                   "A stream or any 360 video (file or URL), or a folder of rendered frames; without one the window "
                   "asks for it");
    cli::Option scene = app.add_option("--scene", arguments->scene, "Scene description whose geometry gives depth");
    app.add_option("--model", arguments->model, "The same by the client's model of it (equistream model)")
        .excludes(scene);
    add_shown_settings(app, *arguments);
    app.add_option("--size", arguments->size, "Of the window, WxH; default: the truth's, else 1280x720");
    cli::add_with_default(app, "--fov", arguments->fov_deg, "Horizontal field of view of an eye, degrees");
    app.add_option("--truth", settings.truth,
                   "Folder of path-traced views along the same path (render --camera perspective). Key x shows them on "
                   "the right")
        .existing_folder();
    app.add_option("--ipd", settings.ipd_m, "Metres between the eyes; default: what the frames are tagged with");
    arguments->hdr.add_to(app);
    cli::add_with_default(app, "--decode", arguments->decode, "auto: by hardware where available").offers(decoders);
    cli::add_with_default(
        app, "--upload", arguments->upload,
        "How decoded pictures come to the GPU: mapped (it reads them where they were decoded to), copied, or "
        "auto (mapped, unless OpenGL runs on the CPU)")
        .offers(uploads);
    cli::add_with_default(app, "--predict", arguments->predict,
                          "Head prediction: auto (until the refresh is seen), off, or so many milliseconds ahead");
    cli::add_former_name(app, "view", "--carry", "--extrapolate", settings.extrapolation_limit_s);
    cli::add_with_default(
        app, "--extrapolate", settings.extrapolation_limit_s,
        "Seconds, at most, by which moving objects are extrapolated while frames are late. 0: they stay where frames "
        "show them. The stream must hold their motion (encode --motion)");
    app.add_flag("--headset", settings.headset,
                 "Show it in a headset by OpenXR (the system's active runtime, or XR_RUNTIME_JSON); the window shows "
                 "what its left eye sees");
    app.add_flag("--paused", settings.paused, "Begin with a still picture");
    cli::add_with_default(app, "--seconds", settings.seconds, "Quit after this many seconds; 0: never");
    cli::add_with_default(app, "--out", settings.out, "Folder for pictures, recordings and paths");
    app.add_flag("--no-config", arguments->no_config,
                 "Neither read nor write what is kept from one run to the next, in "
                 "$XDG_CONFIG_HOME/equistream/view.json or ~/.config");
    cli::add_json_flag(app, arguments->json);
    app.add_flag("--keys", arguments->keys, "Print what each key does, and end");
    return [arguments, &app] { run(*arguments, app); };
}

}  // namespace

int main(int argc, char** argv) {
    Headset::be_quiet();
    const std::string command = cli::quoted_command(argc, argv);
    return cli::run_program(argc, argv,
                            {"view", "Shows a stream in a window, from wherever the head is (h there shows the keys)",
                             "equistream view walk.mp4 --scene scenes/pavilion.json"},
                            [&](cli::CommandLine& app) { return set_up(app, command); });
}
