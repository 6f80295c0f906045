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

#include <algorithm>
#include <charconv>
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
    double fov_deg = default_view_fov_deg, ipd_m = 0;
    bool keys = false, json = false;
};

template <typename Enum, std::size_t n>
Enum parse_word(const char* option, const std::string& word, const std::array<std::string_view, n>& names) {
    const auto found = std::ranges::find(names, word);
    if (found == names.end()) {
        std::string accepted;
        for (const std::string_view name : names)
            accepted += (accepted.empty() ? "" : ", ") + std::string(name);
        throw InputError(expected_found(option, accepted, "'" + word + "'"));
    }
    return Enum(found - names.begin());
}

constexpr std::array<std::string_view, 2> switches = {"off", "on"}, decoders = {"software", "auto"};
/// As PictureUpload has them.
constexpr std::array<std::string_view, 3> uploads = {"auto", "mapped", "copied"};

/// HeadPredictor looks no further ahead.
constexpr double max_predicted_ms = 150;

std::optional<double> parse_prediction(const std::string& text) {
    if (text == "auto")
        return std::nullopt;
    if (text == "off")
        return 0.0;
    double ms = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), ms);
    if (problem != std::errc{} || end != text.data() + text.size() || !(ms >= 0 && ms <= max_predicted_ms))
        throw InputError(expected_found(
            "--predict", "auto, off or milliseconds from 0 to " + in_words(max_predicted_ms), "'" + text + "'"));
    return 1e-3 * ms;
}

/// As play: unless told otherwise by the eye's own depth where geometry gives it, else by the stream's.
void choose_method(Arguments& arguments, const CLI::App& app) {
    ViewerSettings& settings = arguments.settings;
    if (app.count("--method") == 0)
        return;
    const EngineStage& engine = find_engine(arguments.method);
    const std::string method = current_name("view", "--method", engine, arguments.method);
    if (!engine.on_gpu)
        throw InputError(expected_found("--method " + method, "an engine that the viewer has", "one of play alone"));
    const std::string geometry = app.count("--scene") > 0   ? "--scene " + arguments.scene.string()
                                 : app.count("--model") > 0 ? "--model " + arguments.model.string()
                                                            : "";
    if (engine.finds_depth && !geometry.empty())
        throw InputError(expected_found("--method " + method,
                                        "the stream alone (depth of geometry goes by --method eye-depth)", geometry));
    if (engine.needs.eye && geometry.empty())
        throw InputError(expected_found("--method " + method,
                                        "--scene S or --model M, for the eyes' own depth (mesh and splat need none)",
                                        "neither"));
    settings.by_depth = engine.finds_depth || engine.needs.any();
    if (engine.finds_depth)
        settings.finding_engine = method;
}

void complete(Arguments& arguments, const CLI::App& app) {
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
    if (app.count("--anaglyph") > 0)
        settings.anaglyph = &find_anaglyph(arguments.anaglyph);
    if (app.count("--size") > 0) {
        const cli::Size size = cli::parse_size(arguments.size);
        settings.size = {size.width, size.height};
    }
    if (!(arguments.fov_deg >= 10 && arguments.fov_deg <= 150))
        throw InputError(expected_found("--fov", "degrees from 10 to 150", in_words(arguments.fov_deg)));
    if (app.count("--fov") > 0)
        settings.fov_deg = arguments.fov_deg;
    if (app.count("--ipd") > 0) {
        if (!(arguments.ipd_m >= 0 && arguments.ipd_m <= 1))
            throw InputError(expected_found("--ipd", "metres from 0 to 1", in_words(arguments.ipd_m)));
        settings.ipd_m = arguments.ipd_m;
    }
    if (!(settings.extrapolation_limit_s >= 0 && settings.extrapolation_limit_s <= 1))
        throw InputError(expected_found("--carry", "0 to 1 s", in_words(settings.extrapolation_limit_s)));
    if (!(settings.seconds >= 0))
        throw InputError(expected_found("--seconds", "0 or more", in_words(settings.seconds)));
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
    json["truth_psnr_db"] = nullptr;
    if (report.truth_db)
        json["truth_psnr_db"] = *report.truth_db;
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

void run(Arguments& arguments, const CLI::App& app) {
    if (arguments.keys) {
        std::fputs(key_help().c_str(), stdout);
        return;
    }
    if (arguments.settings.source.empty())
        throw InputError("expected a stream or a folder to show, found none");
    complete(arguments, app);
    Viewer viewer(arguments.settings);
    const ViewerReport report = viewer.run();
    if (arguments.json)
        std::printf("%s\n", json_text(json_of(report, arguments.command), 2).c_str());
}

std::function<void()> set_up(CLI::App& app, const std::string& command) {
    auto arguments = std::make_shared<Arguments>();
    arguments->command = command;
    ViewerSettings& settings = arguments->settings;
    app.add_option("source", settings.source,
                   "A stream or any 360 video (file or URL), or a folder of rendered frames");
    CLI::Option* scene = app.add_option("--scene", arguments->scene, "Scene description whose geometry gives depth");
    app.add_option("--model", arguments->model, "The same by the client's model of it (equistream model)")
        ->excludes(scene);
    app.add_option("--method", arguments->method,
                   described(engine_stages(), true) +
                       "; default: eye-depth with --scene or --model, else mesh where the stream has depth, else "
                       "rotation");
    app.add_option("--layout", arguments->layout, "left, right, sbs, anaglyph, headset or sphere")
        ->capture_default_str();
    app.add_option("--anaglyph", arguments->anaglyph, "dubois (default), colour, half-colour or grey");
    app.add_option("--overlay", arguments->overlay, "none, depth, gaps, reliability or motion")->capture_default_str();
    app.add_option(
           "--mirrors", arguments->mirrors,
           "What becomes of mirrors and glass, by depth: images (looked up by where these lie), gaps or surface "
           "(as if painted on it)")
        ->capture_default_str();
    app.add_option("--fill", arguments->fill,
                   "Passes that fill gaps, in order, of " + described(fill_stages(), true) + "; on: " + default_fill +
                       "; off: gaps stay black")
        ->capture_default_str();
    app.add_option("--size", arguments->size, "Of the window, WxH; default: the truth's, else 1280x720");
    app.add_option("--fov", arguments->fov_deg, "Horizontal field of view of an eye, degrees")->capture_default_str();
    app.add_option(
           "--truth", settings.truth,
           "Folder of eyes of the same path, path-traced (render --camera perspective): x shows them on the right")
        ->check(CLI::ExistingDirectory);
    app.add_option("--ipd", arguments->ipd_m, "Metres between the eyes; default: what the frames are tagged with");
    arguments->hdr.add_to(app);
    app.add_option("--loop", arguments->loop, "on: starts again at the end; off: stays there")->capture_default_str();
    app.add_option("--decode", arguments->decode, "auto (by hardware where there is some) or software")
        ->capture_default_str();
    app.add_option(
           "--upload", arguments->upload,
           "How decoded pictures come to the GPU: mapped (it reads them where they were decoded to), copied, or "
           "auto (mapped, unless OpenGL runs on the CPU)")
        ->capture_default_str();
    app.add_option("--predict", arguments->predict,
                   "How far ahead the head is foretold: auto (as long as a refresh takes to be seen), off or MS")
        ->capture_default_str();
    app.add_option("--carry", settings.extrapolation_limit_s,
                   "Where the stream says what moves: seconds by which that is carried on at most while its server is "
                   "late, so that it is where it is by now; 0: it stays where frames show it")
        ->capture_default_str();
    app.add_flag("--headset", settings.headset,
                 "Show it in a headset by OpenXR (the system's active runtime, or XR_RUNTIME_JSON); the window shows "
                 "what its left eye sees");
    app.add_flag("--paused", settings.paused, "Begin with a still picture");
    app.add_flag("--times", settings.times, "Show frame times by stage (t)");
    app.add_option("--seconds", settings.seconds, "End by itself after so long; 0: never")->capture_default_str();
    app.add_option("--out", settings.out, "Folder for pictures, recordings and paths")->capture_default_str();
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
                            [&](CLI::App& app) { return set_up(app, command); });
}
