/// `equistream view`: a stream in a window, seen from wherever the viewer's head is.
#include <client/view/viewer.h>
#include <client/view/xr/headset.h>
#include <programs/cli/hdr_options.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>
#include <programs/cli/stage_names.h>

#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/text.h>

#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace {

using namespace equistream;

struct Arguments {
    std::string command;
    ViewerSettings settings;
    HdrOptions hdr;
    std::filesystem::path scene, model;
    std::string size, layout = "left", anaglyph, overlay = "none", method, fill = "on", loop = "on", mirrors = "images",
                      decode = "auto", upload = "auto", predict = "auto";
    double fov_deg = default_view_fov_deg;
    bool keys = false, json = false;
};

template <typename Value, typename Words>
Value parse_word(const char* option, const std::string& word, const Words& words) {
    return cli::parse_word<Value>(option, word, words, ", ");
}

constexpr std::array switches = {"off", "on"}, decoders = {"software", "auto"};
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

/// As play: unless told otherwise by the eye's own depth where geometry gives it, else by the stream's.
void choose_method(Arguments& arguments, const cli::CommandLine& app) {
    ViewerSettings& settings = arguments.settings;
    if (!app.is_given("--method"))
        return;
    const EngineStage& engine = find_engine(arguments.method);
    const std::string method = current_name("view", "--method", engine, arguments.method);
    cli::require(engine.on_gpu, "--method " + method, "an engine that the viewer has", "one of play alone");
    const std::string geometry = app.is_given("--scene")   ? "--scene " + arguments.scene.string()
                                 : app.is_given("--model") ? "--model " + arguments.model.string()
                                                           : "";
    cli::require(!engine.finds_depth || geometry.empty(), "--method " + method,
                 "the stream alone (depth of geometry goes by --method eye-depth)", geometry);
    cli::require(!engine.needs.eye || !geometry.empty(), "--method " + method,
                 "--scene S or --model M, for the eyes' own depth (mesh and splat need none)", "neither");
    settings.by_depth = engine.finds_depth || engine.needs.any();
    if (engine.finds_depth)
        settings.finding_engine = method;
}

void complete(Arguments& arguments, const cli::CommandLine& app) {
    ViewerSettings& settings = arguments.settings;
    settings.layout = parse_word<gl::DisplayLayout>("--layout", arguments.layout, gl::display_layout_names);
    settings.overlay = parse_word<gl::Overlay>("--overlay", arguments.overlay, gl::overlay_names);
    choose_method(arguments, app);
    settings.mirrors = find_mirror_treatment(arguments.mirrors);
    settings.fill = arguments.fill != "off";
    std::vector<std::string> notes;
    if (arguments.fill != "on" && arguments.fill != "off")
        settings.fill_chain = gl::with_passes_of_gpu(arguments.fill, notes);
    parse_fills(settings.fill_chain);  // says which words are accepted
    for (const std::string& note : notes)
        std::fprintf(stderr, "equistream view: note: %s\n", note.c_str());
    settings.loop = parse_word<int>("--loop", arguments.loop, switches) == 1;
    settings.hardware = parse_word<int>("--decode", arguments.decode, decoders) == 1;
    settings.upload = parse_word<PictureUpload>("--upload", arguments.upload, uploads);
    settings.hdr_display = arguments.hdr.display();
    settings.predict_s = parse_prediction(arguments.predict);
    if (app.is_given("--anaglyph"))
        settings.anaglyph = &find_anaglyph(arguments.anaglyph);
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
    cli::require(settings.extrapolation_limit_s >= 0 && settings.extrapolation_limit_s <= 1, "--carry", "0 to 1 s",
                 in_words(settings.extrapolation_limit_s));
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
    return json;
}

void run(Arguments& arguments, const cli::CommandLine& app) {
    if (arguments.keys) {
        std::fputs(key_help().c_str(), stdout);
        return;
    }
    if (arguments.settings.source.empty())
        throw InputError("expected a stream or a folder to show, found none");
    cli::hide_secret(arguments.settings.source);
    complete(arguments, app);
    Viewer viewer(arguments.settings);
    const ViewerReport report = viewer.run();
    if (arguments.json)
        std::printf("%s\n", json_text(json_of(report, arguments.command), 2).c_str());
}

std::function<void()> set_up(cli::CommandLine& app, const std::string& command) {
    auto arguments = std::make_shared<Arguments>();
    arguments->command = command;
    ViewerSettings& settings = arguments->settings;
    app.add_option("source", settings.source,
                   "A stream or any 360 video (file or URL), or a folder of rendered frames");
    cli::Option scene = app.add_option("--scene", arguments->scene, "Scene description whose geometry gives depth");
    app.add_option("--model", arguments->model, "The same by the client's model of it (equistream model)")
        .excludes(scene);
    std::vector<std::string_view> methods;
    for (const EngineStage& engine : engine_stages())
        if (engine.on_gpu)
            methods.push_back(engine.name);
    app.add_option("--method", arguments->method,
                   described(engine_stages(), true) +
                       "; default: eye-depth with --scene or --model, else mesh where the stream has depth, else "
                       "rotation")
        .offers(methods);
    cli::add_with_default(app, "--layout", arguments->layout, "Which eyes the window shows, and how")
        .offers(gl::display_layout_names);
    app.add_option("--anaglyph", arguments->anaglyph, "Colours for red and cyan glasses (default: dubois)")
        .offers(anaglyphs());
    cli::add_with_default(app, "--overlay", arguments->overlay, "What is laid over the picture")
        .offers(gl::overlay_names);
    cli::add_with_default(
        app, "--mirrors", arguments->mirrors,
        "What becomes of mirrors and glass, by depth: images (looked up by where these lie), gaps or surface "
        "(as if painted on it)")
        .offers(mirror_treatment_names());
    cli::add_with_default(app, "--fill", arguments->fill,
                          "Passes that fill gaps, in order, of " + described(fill_stages(), true) +
                              "; on: " + default_fill + "; off: gaps stay black");
    app.add_option("--size", arguments->size, "Of the window, WxH; default: the truth's, else 1280x720");
    cli::add_with_default(app, "--fov", arguments->fov_deg, "Horizontal field of view of an eye, degrees");
    app.add_option(
           "--truth", settings.truth,
           "Folder of eyes of the same path, path-traced (render --camera perspective): x shows them on the right")
        .existing_folder();
    app.add_option("--ipd", settings.ipd_m, "Metres between the eyes; default: what the frames are tagged with");
    arguments->hdr.add_to(app);
    cli::add_with_default(app, "--loop", arguments->loop, "on: starts again at the end; off: stays there")
        .offers(switches);
    cli::add_with_default(app, "--decode", arguments->decode, "auto: by hardware where there is some").offers(decoders);
    cli::add_with_default(
        app, "--upload", arguments->upload,
        "How decoded pictures come to the GPU: mapped (it reads them where they were decoded to), copied, or "
        "auto (mapped, unless OpenGL runs on the CPU)")
        .offers(uploads);
    cli::add_with_default(
        app, "--predict", arguments->predict,
        "How far ahead the head is foretold: auto (as long as a refresh takes to be seen), off or MS");
    cli::add_with_default(
        app, "--carry", settings.extrapolation_limit_s,
        "Where the stream says what moves: seconds by which that is carried on at most while its server is "
        "late, so that it is where it is by now; 0: it stays where frames show it");
    app.add_flag("--headset", settings.headset,
                 "Show it in a headset by OpenXR (the system's active runtime, or XR_RUNTIME_JSON); the window shows "
                 "what its left eye sees");
    app.add_flag("--paused", settings.paused, "Begin with a still picture");
    app.add_flag("--times", settings.times, "Show frame times by stage (t)");
    cli::add_with_default(app, "--seconds", settings.seconds, "End by itself after so long; 0: never");
    cli::add_with_default(app, "--out", settings.out, "Folder for pictures, recordings and paths");
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
