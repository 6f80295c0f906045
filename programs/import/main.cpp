/// `equistream import`: other renderers' EXR sequences made our frames.
#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/text.h>
#include <host-adapters/import/import.h>
#include <programs/cli/paths.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>

#include <array>
#include <cmath>
#include <cstdio>

namespace {

using namespace equistream;

struct Arguments {
    files::ImportSettings settings;
    std::string channels, depth, backward, forward, normals, range, eye = "centre", lock = "path", progress = "auto",
                                                                    up;
    std::string denoise = "off", window;
    std::optional<cli::FrameRange> frames;
    double fov_deg = 0;
    bool mirrored = false, encoded = false, dry_run = false, json = false;
};

void require(bool good, const char* option, const char* expected, double found) {
    cli::require(good, option, expected, std::to_string(found));
}

/// "-90,90,-90,90": longitudes, then latitudes, in degrees.
LongitudeLatitudeRange parse_range(const std::string& text) {
    const std::vector<std::string_view> words = split_at_commas(text);
    std::vector<double> degrees;
    for (const std::string_view word : words)
        if (const auto value = parsed_number(word))
            degrees.push_back(*value);
    const bool right = words.size() == 4 && degrees.size() == 4 && degrees[0] < degrees[1] && degrees[2] < degrees[3] &&
                       degrees[0] >= -360 && degrees[1] <= 360 && degrees[1] - degrees[0] <= 360 && degrees[2] >= -90 &&
                       degrees[3] <= 90;
    cli::require(right, "--range", "WEST,EAST,SOUTH,NORTH in degrees, at most 360 by 180", "'" + text + "'");
    const double unit = pi / 180;
    return {degrees[0] * unit, degrees[1] * unit, degrees[2] * unit, degrees[3] * unit};
}

/// "auto", or "640,320" in pixels with --density.
void parse_window(const std::string& text, bool has_density, files::ImportSettings& settings) {
    settings.window = true;
    if (text == "auto") {
        cli::require(!has_density, "--density", "--window X,Y", "--window auto");
        return;
    }
    const std::vector<std::string_view> words = split_at_commas(text);
    const auto x = parsed_number(words.front()), y = parsed_number(words.back());
    const auto is_pixel = [](const std::optional<double>& value) {
        return value && *value >= 0 && *value < max_image_side && *value == std::floor(*value);
    };
    cli::require(words.size() == 2 && is_pixel(x) && is_pixel(y), "--window", "auto, or X,Y in pixels",
                 "'" + text + "'");
    cli::require(has_density, "--window " + text, "--density COLUMNS as well", "none");
    cli::require(settings.density > 0 && settings.density <= max_image_side, "--density",
                 "1 to " + std::to_string(max_image_side), std::to_string(settings.density));
    settings.corner = {int(*x), int(*y)};
}

void complete(Arguments& a, const cli::CommandLine& app) {
    using namespace files;
    const auto given = [&](const char* option) { return app.is_given(option); };
    ImportSettings& s = a.settings;
    Overrides& o = s.overrides;
    if (given("--channels"))
        o.channels = parse_channels(a.channels);
    if (given("--depth"))
        o.depth = cli::parse_word<DepthKind>("--depth", a.depth, std::array{"radial", "planar", "position"});
    if (const auto& scale_m = o.depth_scale_m)
        require(*scale_m > 0 && *scale_m < 1e9, "--depth-scale", "metres above 0", *scale_m);
    if (const auto& near_m = o.near_plane_m)
        require(*near_m >= 0 && *near_m < 1e9, "--near", "metres from 0", *near_m);
    if (given("--backward"))
        o.backward = parse_motion(a.backward, "--backward");
    if (given("--forward"))
        o.forward = parse_motion(a.forward, "--forward");
    if (given("--normals"))
        o.normals =
            cli::parse_word<NormalSpace>("--normals", a.normals, std::array{"world", "camera", "camera-z-forward"});
    if (given("--normals-encoded"))
        o.normals_encoded = a.encoded;
    if (given("--mirrored"))
        o.mirrored = a.mirrored;
    if (const auto& at = o.forward_at)
        require(*at >= 0 && *at <= 1, "--forward-at", "a fraction of the width, 0 to 1", *at);
    if (given("--up"))
        o.z_up = cli::parse_word("--up", a.up, std::array{"y", "z"}) == 1;
    cli::parse_word("--camera", s.camera, std::array{"auto", "equirect", "ods", "perspective"});
    cli::require(s.camera != "ods" || s.info.ipd_m > 0, "--camera ods", "eyes that are apart (--ipd)", "--ipd 0");
    cli::require(s.camera != "ods" || !given("--window"), "--camera ods", "whole pictures", "--window");
    if (given("--range"))
        s.range = parse_range(a.range);
    if (given("--fov")) {
        require(a.fov_deg > 0.1 && a.fov_deg < 179, "--fov", "degrees above 0.1 and below 179", a.fov_deg);
        s.fov_x_rad = a.fov_deg * pi / 180;
    }
    if (const auto& fps = s.frames_per_second)
        require(*fps >= 0.001 && *fps <= 1000, "--fps", "0.001 to 1000", *fps);
    require(s.info.ipd_m >= 0 && s.info.ipd_m <= max_ipd_m, "--ipd", "metres from 0 to 10", s.info.ipd_m);
    require(s.info.head_radius_m >= 0 && s.info.head_radius_m <= max_head_box_radius_m, "--lean",
            "metres from 0 to 1000", s.info.head_radius_m);
    require(s.info.exposure >= 1e-12 && s.info.exposure <= 1e12, "--exposure", "a number above 0", s.info.exposure);
    s.info.eye = cli::parse_word<Eye>("--eye", a.eye, eye_names);
    for (const char* option : {"--eye", "--ipd", "--lean", "--lock", "--exposure", "--name"})
        if (given(option))
            s.told.insert(option);
    if (given("--window"))
        parse_window(a.window, given("--density"), s);
    cli::require(given("--window") || !given("--density"), "--density", "--window X,Y as well", "none");
    for (const char* option : {"--camera", "--range", "--fov"})
        cli::require(s.density == 0 || !given(option), option, "none with --window X,Y", "one");
    const bool locked_to_path = cli::parse_word("--lock", a.lock, std::array{"path", "world"}) == 0;
    s.info.lock = locked_to_path ? AxisLock::path : AxisLock::world;
    cli::require(s.info.scene.size() <= 255, "--name", "at most 255 bytes", std::to_string(s.info.scene.size()));
    s.denoise = denoise_quality(a.denoise);
    if (a.frames) {
        s.first_frame = a.frames->first;
        s.last_frame = a.frames->last;
    }
    cli::require(!s.out.empty() || a.dry_run, "--out", "a folder (or --dry-run)", "none");
    cli::require_not_read("--out", s.out, std::vector<std::filesystem::path>(s.sources.begin(), s.sources.end()));
}

using Made = std::vector<files::ImportedFrames>;

nlohmann::ordered_json as_json(const Arguments& a, const files::ImportPlan& plan, const Made& made) {
    nlohmann::ordered_json json = cli::provenance(a.settings.command);
    json["out"] = a.dry_run ? nlohmann::ordered_json() : nlohmann::ordered_json(a.settings.out.string());
    json["frames"] = plan.files.frames.size();
    json["views"] = plan.views.size();
    json["findings"] = nlohmann::ordered_json::array();
    for (const files::Finding& finding : plan.findings)
        json["findings"].push_back({{"found", finding.found}, {"taken_for", finding.taken_for}, {"why", finding.why}});
    json["notes"] = plan.notes;
    json["written"] = nlohmann::ordered_json::array();
    for (const files::ImportedFrames& view : made)
        json["written"].push_back({{"folder", view.folder.string()}, {"imported", view.imported}, {"kept", view.kept}});
    return json;
}

void print_json(const Arguments& a, const files::ImportPlan& plan, const Made& made = {}) {
    std::printf("%s\n", json_text(as_json(a, plan, made), 2).c_str());
}

void run(Arguments& a, const cli::CommandLine& app) {
    complete(a, app);
    const cli::ProgressStyle style = cli::parse_progress(a.progress);
    files::ImportPlan plan = files::make_plan(a.settings);
    if (!a.json)
        std::fputs(plan.table().c_str(), stdout);
    std::fflush(stdout);
    if (a.dry_run)
        return a.json ? print_json(a, plan) : void(std::puts("nothing is imported (--dry-run)"));
    const std::size_t known_notes = plan.notes.size();
    const double total = double(plan.files.frames.size() * plan.views.size());
    Made made;
    {
        cli::Progress progress("import", total, style);
        made = files::run_import(a.settings, plan, [&](std::size_t done, std::int64_t index) {
            progress.step(double(done), "frame " + std::to_string(index));
        });
    }
    if (a.json)
        return print_json(a, plan, made);
    for (std::size_t i = known_notes; i < plan.notes.size(); ++i)
        std::printf("note: %s\n", plan.notes[i].c_str());
    for (const files::ImportedFrames& view : made)
        std::printf("%s: imported %zu, kept %zu frames\n", view.folder.c_str(), view.imported, view.kept);
}

std::function<void()> set_up(cli::CommandLine& app, const std::string& command) {
    auto a = std::make_shared<Arguments>();
    files::ImportSettings& s = a->settings;
    files::Overrides& o = s.overrides;
    s.command = command;
    app.add_option("SOURCE", s.sources,
                   "Folders, files or patterns (shot.####.exr); several where each AOV has files of its own")
        .required();
    app.add_option("--out", s.out, "Folder for centre/, left/, right/ or window/");
    app.add_flag("--dry-run", a->dry_run, "Only say what was found and what it is taken for");
    cli::add_with_default(app, "--preset", s.preset, "Whose conventions the frames follow")
        .offers(std::array{"auto", "none", "cycles", "luxcore", "mitsuba", "pbrt", "equistream"});
    app.add_option("--channels", a->channels,
                   "PLANE=LAYER or PLANE=CHANNEL+CHANNEL..., between commas; PLANE=none leaves one out");
    app.add_option("--depth", a->depth,
                   "radial (along the ray), planar (along the axis) or position (the point, camera space)")
        .offers(std::array{"radial", "planar", "position"});
    app.add_option("--depth-scale", o.depth_scale_m,
                   "Metres per unit of depth, and of positions in worldToCamera (default: 1)");
    app.add_option("--near", o.near_plane_m, "Metres along the axis by which depth was shortened");
    app.add_option("--miss", o.miss_value, "The value that means nothing was hit");
    app.add_option("--miss-above", o.miss_above, "This and more means nothing was hit (default: 1e9)");
    app.add_option("--backward", a->backward,
                   "Words between commas: to-previous or from-previous; pixels, normalised or ndc; y-down or y-up");
    app.add_option("--forward", a->forward, "The same with to-next or from-next");
    app.add_option("--normals", a->normals, "world, camera (looking along -Z) or camera-z-forward")
        .offers(std::array{"world", "camera", "camera-z-forward"});
    app.add_flag("--normals-encoded", a->encoded, "Normals are stored as (n + 1) / 2");
    app.add_option(
           "--camera", s.camera,
           "Of the pictures (default: a sphere where one is 2:1); ods: omnidirectional stereo, of views left and "
           "right or of --eye")
        .offers(std::array{"equirect", "ods", "perspective"});
    app.add_option("--range", a->range, "WEST,EAST,SOUTH,NORTH of an equirect picture, degrees");
    app.add_option("--fov", a->fov_deg, "Horizontal, degrees, of a perspective picture");
    app.add_option("--window", a->window,
                   "The pictures are windows of a denser sphere, and go to OUT/window. auto: that sphere is their EXR "
                   "display window. X,Y: their upper left pixel in it (with --density)");
    app.add_option("--density", s.density, "Columns of the sphere that windows at X,Y are parts of");
    app.add_flag("--mirrored", a->mirrored, "The sphere's longitude grows to the left");
    app.add_option("--forward-at", o.forward_at,
                   "Where the camera looks, as a fraction of the sphere's width, once mirrored (default: 0.5)");
    app.add_option("--up", a->up, "The source's world's up").offers(std::array{"y", "z"});
    app.add_option("--path", s.path, "CSV of the head's poses in the source's world, metres");
    app.add_option("--fps", s.frames_per_second, "Frames a second (default: the files', else 30)");
    cli::add_with_default(app, "--eye", a->eye, "Whose pictures they are, where the files do not say")
        .offers(std::array{"centre", "left", "right"});
    cli::add_with_default(app, "--ipd", s.info.ipd_m, "Metres between the eyes");
    cli::add_with_default(app, "--lean", s.info.head_radius_m, "Radius of the head box, metres");
    cli::add_with_default(app, "--lock", a->lock, "path: the sphere turns with its camera; world: it does not")
        .offers(std::array{"path", "world"});
    cli::add_with_default(app, "--colour-space", s.colour_space, "auto: by the files' chromaticities")
        .offers(std::array{"auto", "rec709", "rec2020", "acescg", "aces2065-1"});
    cli::add_with_default(app, "--exposure", s.info.exposure, "Factor on radiance before the display transform");
    app.add_option("--denoise", a->denoise,
                   "Take the noise out of colour by Open Image Denoise (pip install pyoidn): quickly or well")
        .one_of(denoise_quality_names)
        .with_default();
    app.add_option("--name", s.info.scene, "The scene's name, for the record");
    cli::add_frames_option(app, a->frames, "FIRST-LAST or one number (default: all)");
    app.add_flag("--overwrite", s.overwrite, "Import frames again that are there; replace other frames");
    cli::add_json_flag(app, a->json);
    cli::add_progress_option(app, a->progress);
    return [a, &app] { run(*a, app); };
}

}  // namespace

int main(int argc, char** argv) {
    const std::string command = cli::quoted_command(argc, argv);
    return cli::run_program(argc, argv,
                            {"import", "Makes frames of any renderer's EXR sequences, and says how it read them",
                             "equistream import blender/shot.####.exr --preset cycles --path head.csv --out shot"},
                            [&](cli::CommandLine& app) { return set_up(app, command); });
}
