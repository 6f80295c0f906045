#include "host.h"

#include <equistream/aov_groups.h>
#include <equistream/camera.h>
#include <equistream/denoise_quality.h>
#include <equistream/error.h>
#include <equistream/patches.h>
#include <equistream/stream.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>

namespace equistream::render_command {
namespace {

const std::vector<std::string> sample_spreads = {"even", "angle"};

/// As typed; what is not a plain number is read by checked().
struct Typed {
    RenderOptions options;
    std::string host, camera = "equirect", eye, small_eye, lock = "world", size, range;
    std::string progress = "auto", denoise = "off", window, samples = sample_spreads.front(), part;
    double fps = 0, fov_deg = 90;
    int density = 0;
    cli::Option fov_option, fps_option, patch_budget, patch_side, density_option;
};

double number(std::string_view text, const std::string& option, const std::string& expected) {
    double value = 0;
    const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || result.ec != std::errc() || result.ptr != text.data() + text.size())
        throw InputError(expected_found(option, expected, "'" + std::string(text) + "'"));
    return value;
}

/// "180,90": spans in degrees around straight ahead.
LongitudeLatitudeRange parse_range(const std::string& text) {
    const std::string expected = "LON,LAT in degrees, up to 360,180";
    const std::vector<std::string_view> words = split_at_commas(text);
    if (words.size() != 2)
        throw InputError(expected_found("--range", expected, "'" + text + "'"));
    const double longitude = number(words[0], "--range", expected);
    const double latitude = number(words[1], "--range", expected);
    if (!(longitude > 0 && longitude <= 360 && latitude > 0 && latitude <= 180))
        throw InputError(expected_found("--range", expected, "'" + text + "'"));
    const double half_longitude = longitude * pi / 360, half_latitude = latitude * pi / 360;
    return {-half_longitude, half_longitude, -half_latitude, half_latitude};
}

/// "10,-5,60x45": where its middle is and what it covers, degrees; "gaze,60x45".
WindowOptions parse_window(const std::string& text, int columns) {
    const std::string expected = "AZ,EL,WxH or gaze,WxH in degrees", found = "'" + text + "'";
    const std::vector<std::string_view> words = split_at_commas(text);
    const std::size_t cross = words.back().find('x');
    WindowOptions window;
    window.follows_gaze = words.size() == 2 && words[0] == "gaze";
    if ((words.size() != 3 && !window.follows_gaze) || cross == std::string_view::npos)
        throw InputError(expected_found("--window", expected, found));
    const double width = number(words.back().substr(0, cross), "--window", expected);
    const double height = number(words.back().substr(cross + 1), "--window", expected);
    if (!(width > 0 && width < 360 && height > 0 && height <= 180))
        throw InputError(
            expected_found("--window", "a width above 0 and below 360 degrees, a height of at most 180", found));
    if (!window.follows_gaze) {
        const double azimuth = number(words[0], "--window", expected),
                     elevation = number(words[1], "--window", expected);
        if (!(std::abs(azimuth) <= 360 && std::abs(elevation) <= 90))
            throw InputError(expected_found("--window", "AZ from -360 to 360 and EL from -90 to 90 degrees", found));
        const auto d = direction_from_longitude_latitude(azimuth * pi / 180, elevation * pi / 180);
        window.middle = {d.x, d.y, d.z};
    }
    window.grid = window_grid(columns, width * pi / 180, height * pi / 180);
    if (const auto problem = window_grid_problem(window.grid))
        throw InputError("--" + *problem);
    return window;
}

/// Columns of a whole sphere's grid that is as dense as these pixels, in their denser direction.
int columns_as_dense_as(const cli::Size& sphere) {
    return std::max(sphere.width, 2 * sphere.height);
}

/// The window around `o`, a whole sphere of one eye.
WindowOptions checked_window(const Typed& typed, const RenderOptions& o) {
    const std::string besides = o.camera == ES_PERSPECTIVE ? "--camera perspective"
                                : o.eyes.size() > 1        ? "--eye both"
                                : !typed.range.empty()     ? "--range"
                                : o.layers                 ? "--layers"
                                : o.patches                ? "--patches"
                                                           : "";
    if (!besides.empty())
        throw InputError(expected_found("--window", "a whole sphere of one eye, without --layers and --patches",
                                        besides + "; leave one of the two out"));
    const int columns = typed.density_option.is_given() ? typed.density : 4 * o.size.width;
    const int coarser = columns_as_dense_as(o.size);
    if (columns % (2 * window_block_px) != 0 || columns > max_image_side || columns <= coarser)
        throw InputError(expected_found("--density",
                                        "a multiple of 32, more than the " + std::to_string(coarser) +
                                            " columns of a sphere of --size " + size_text(o.size.width, o.size.height) +
                                            ", up to " + std::to_string(max_image_side),
                                        std::to_string(columns)));
    return parse_window(typed.window, columns);
}

/// "3/8"; "all/8".
FramePart parse_part(const std::string& text) {
    const auto read = [](std::string_view word, std::uint32_t& value) {
        const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
        return result.ec == std::errc() && result.ptr == word.data() + word.size() && value >= 1 &&
               value <= max_frame_parts;
    };
    const std::string_view words = text;
    const std::size_t slash = words.find('/');
    FramePart part;
    const bool good = slash != words.npos && read(words.substr(slash + 1), part.count) &&
                      (words.substr(0, slash) == "all" || read(words.substr(0, slash), part.number)) &&
                      part.number <= part.count;
    cli::require(good, "--part", "K/N or all/N, K from 1 to N, N up to " + std::to_string(max_frame_parts),
                 "'" + text + "'");
    return part;
}

/// Frames in parts are independent, and of tiles that all parts know alike.
void require_parts_possible(const RenderOptions& o) {
    const std::string besides = o.accumulate > 0 ? "--accumulate"
                                : o.patches      ? "--patches"
                                : o.window       ? "--window"
                                : o.follow       ? "--follow"
                                                 : "";
    if (!besides.empty())
        throw InputError(
            expected_found("--part", "frames without --accumulate, --patches, --window and --follow", besides));
}

es_eye parse_eye(const std::string& text) {
    return text == "left" ? ES_EYE_LEFT : text == "right" ? ES_EYE_RIGHT : ES_EYE_CENTRE;
}

/// Every ray of omnidirectional stereo begins elsewhere, and what goes with one place does not fit it.
void require_ods_possible(const Typed& typed, const RenderOptions& o) {
    const std::string besides = typed.eye == "centre"      ? "--eye centre"
                                : o.layers                 ? "--layers"
                                : o.patches                ? "--patches"
                                : !typed.window.empty()    ? "--window"
                                : !typed.small_eye.empty() ? "--small"
                                : o.accumulate > 0         ? "--accumulate"
                                : o.follow                 ? "--follow (serve)"
                                                           : "";
    if (!besides.empty())
        throw InputError(
            expected_found("--camera ods", "--eye left, right or both, and nothing besides their spheres", besides));
}

/// The host is the program: `equistream render` chooses it by the command line, before any settings are read.
void require_own_host(const std::string& host, const std::string& own) {
    if (host != own)
        throw InputError(
            expected_found("--host", own + " (--host chooses another on the command line only, not in a settings file)",
                           "'" + host + "'"));
}

/// Of so many columns over the range, so that pixels are square.
double square_rows(int columns, const LongitudeLatitudeRange& range) {
    return columns * range.latitude_span() / range.longitude_span();
}

cli::Size default_sphere_size(const LongitudeLatitudeRange& range) {
    constexpr int columns = 1920, max_rows = 4 * columns;
    const double rows = square_rows(columns, range);
    if (rows > max_rows)
        throw InputError(expected_found("--range", "at most 4 times as high as wide, or --size as well",
                                        formatted("%d columns of square pixels, %.0f high", columns, rows)));
    return {columns, std::max(2, 2 * int(std::lround(rows / 2)))};
}

void note_pixels_that_are_not_square(const RenderOptions& o) {
    const double rows = square_rows(o.size.width, o.range);
    if (std::abs(o.size.height - rows) < 1)
        return;
    std::fprintf(
        stderr,
        "equistream render: note: pixels of %dx%d over %g by %g degrees are not square; those of %ld rows are\n",
        o.size.width, o.size.height, o.range.longitude_span() * 180 / pi, o.range.latitude_span() * 180 / pi,
        std::lround(rows));
}

RenderOptions checked(const Typed& typed, const std::string& own_host) {
    require_own_host(typed.host, own_host);
    RenderOptions o = typed.options;
    cli::require(!o.out.empty(), "--out", "the name of a folder", "''");
    o.camera = typed.camera == "perspective" ? ES_PERSPECTIVE : typed.camera == "ods" ? ES_ODS : ES_EQUIRECT;
    const bool sphere = o.camera != ES_PERSPECTIVE;
    const std::string eye = !typed.eye.empty() ? typed.eye : o.camera == ES_ODS ? "both" : "centre";
    o.eyes = eye == "both" ? std::vector{ES_EYE_LEFT, ES_EYE_RIGHT} : std::vector{parse_eye(eye)};
    if (!typed.small_eye.empty())
        o.small_eye = parse_eye(typed.small_eye);
    o.lock = sphere && typed.lock == "path" ? ES_LOCK_PATH : ES_LOCK_WORLD;  // a view turns with the head as it is
    if (typed.fps_option.is_given()) {
        if (!std::isfinite(typed.fps))
            throw InputError(expected_found("--fps", "a finite number", std::to_string(typed.fps)));
        o.frames_per_second = typed.fps;
    }
    if (!sphere && !typed.range.empty())
        throw InputError(expected_found("--range", "--camera equirect", "--camera perspective (see --fov)"));
    if (!typed.range.empty())
        o.range = parse_range(typed.range);
    const bool windowed = !typed.window.empty();
    o.size = !typed.size.empty() ? cli::parse_size(typed.size)
             : !sphere           ? cli::Size{1280, 720}
             : windowed          ? cli::Size{480, 240}
                                 : default_sphere_size(o.range);
    if (o.camera == ES_ODS)
        require_ods_possible(typed, o);
    if (windowed)
        o.window = checked_window(typed, o);
    else if (typed.density_option.is_given())
        throw InputError(expected_found("--density", "--window as well", "none"));
    if (o.layers && o.eyes.size() > 1)
        throw InputError(
            expected_found("--layers", "one --eye, whose hidden layer goes into DIR/hidden", "--eye both"));
    if (o.patches && (!sphere || o.eyes.size() > 1))
        throw InputError(expected_found("--patches", "one sphere, whose patches go into DIR/patches",
                                        sphere ? "--eye both" : "--camera perspective"));
    if (!o.patches && (typed.patch_budget.is_given() || typed.patch_side.is_given()))
        throw InputError(expected_found(typed.patch_side.is_given() ? "--patch-side" : "--patch-budget",
                                        "--patches as well", "none"));
    if (o.small_eye && (o.size.width % 4 != 0 || o.size.height % 4 != 0))
        throw InputError(expected_found("--small", "a --size whose sides are multiples of 4",
                                        std::to_string(o.size.width) + "x" + std::to_string(o.size.height)));
    if (o.small_eye && (o.size.width / 4 < min_track_side || o.size.height / 4 < min_track_side))
        std::fprintf(stderr,
                     "equistream render: note: --small has %dx%d pixels; encode needs sides of at least %d: take a "
                     "larger --size\n",
                     o.size.width / 4, o.size.height / 4, min_track_side);
    if (sphere && typed.fov_option.is_given())
        throw InputError(
            expected_found("--fov", "--camera perspective", "--camera " + typed.camera + " (see --range)"));
    if (o.accumulate > 0 && (o.layers || o.patches || o.small_eye))
        std::fprintf(stderr,
                     "equistream render: note: --accumulate averages the first surfaces only; %s is not averaged\n",
                     o.layers    ? "--layers"
                     : o.patches ? "--patches"
                                 : "--small");
    if (o.accumulate > 0 && o.window && o.window->follows_gaze)
        std::fprintf(stderr,
                     "equistream render: note: --accumulate averages the sphere around a window that follows the "
                     "gaze; the window itself is not averaged\n");
    o.fov_rad = typed.fov_deg * pi / 180;
    if (sphere && !typed.size.empty())
        note_pixels_that_are_not_square(o);
    const std::vector<std::string> planes = parse_aov_groups(o.aovs);
    if ((o.window || o.accumulate > 0) && std::ranges::find(planes, "crypto_object") != planes.end())
        throw InputError(expected_found("--aovs cryptomatte", "whole pictures, without --window and --accumulate",
                                        o.window ? "--window" : "--accumulate"));
    o.samples_by_angle = typed.samples == sample_spreads.back();
    if (o.samples_by_angle && (!sphere || o.accumulate > 0 || o.patches))
        throw InputError(expected_found("--samples angle", "spheres of independent frames",
                                        !sphere     ? "--camera perspective"
                                        : o.patches ? "--patches"
                                                    : "--accumulate"));
    o.denoise = static_cast<es_denoise>(denoise_quality(typed.denoise));
    o.progress = cli::parse_progress(typed.progress);
    if (!typed.part.empty()) {
        o.part = parse_part(typed.part);
        require_parts_possible(o);
    }
    return o;
}

void add_camera_options(cli::CommandLine& app, Typed& t) {
    app.add_option("--camera", t.camera,
                   "equirect: whole sphere. perspective: flat view. ods: omnidirectional stereo, each column seen by "
                   "an eye turned towards it")
        .one_of({"equirect", "perspective", "ods"})
        .with_default();
    app.add_option("--eye", t.eye,
                   "Where the camera stands; both: left and right (default: centre; with --camera ods both)")
        .one_of({"centre", "left", "right", "both"});
    app.add_option("--ipd", t.options.ipd_m, "Distance between the eyes, metres").between(0.0, 1.0).with_default();
    app.add_option("--lock", t.lock, "Whether a sphere's axes stay the world's or turn with the path")
        .one_of({"world", "path"})
        .with_default();
    app.add_option("--size", t.size,
                   "WxH in pixels (default 1920x960, with --range 1920 columns of square pixels; perspective 1280x720; "
                   "with --window 480x240)");
    t.fov_option = app.add_option("--fov", t.fov_deg, "Horizontal field of view of a perspective view, degrees")
                       .between(1.0, 170.0)
                       .with_default();
    app.add_option("--range", t.range, "LON,LAT: degrees a sphere covers, centred ahead (default 360,180)");
    app.add_option("--small", t.small_eye, "Also render this eye at a quarter of width and height, into DIR/small")
        .one_of({"centre", "left", "right"});
    app.add_option("--window", t.window,
                   "AZ,EL,WxH or gaze,WxH: also render this part of a denser sphere, degrees, into DIR/window");
    t.density_option = app.add_option("--density", t.density,
                                      "Columns of the sphere a window is part of (default: four times --size's)");
    app.add_flag("--layers", t.options.layers,
                 "Also render the surfaces behind the first ones that eyes in the head box see, into DIR/hidden");
    app.add_flag("--patches", t.options.patches,
                 "Also render the surfaces that eyes in the head box uncover, as patches of spheres beside this one, "
                 "into DIR/patches");
    t.patch_budget = app.add_option("--patch-budget", t.options.patch_budget_percent,
                                    "Pixels of all patches together, at most, as a percentage of the sphere's")
                         .between(0.1, 100.0)
                         .with_default();
    t.patch_side =
        app.add_option("--patch-side", t.options.patch_side,
                       "Pixels a patch is wide and high; default: as few as the budget's atlas allows, 4 at 1920x960")
            .between(min_patch_side, max_patch_side);
}

void add_frame_options(cli::CommandLine& app, Typed& t) {
    app.add_option("--path", t.options.path, "Camera path (CSV) instead of the scene's").existing_file();
    cli::add_frames_option(app, t.options.frames, "FIRST-LAST or one number (default: the whole path)");
    app.add_option("--part", t.part,
                   "K/N: render part K of N of every frame, and keep it in DIR. all/N: join the parts to whole frames, "
                   "byte for byte as if rendered at once. equistream farm does both");
    t.fps_option = app.add_option("--fps", t.fps, "Frames per second (default: the scene's)").between(0.001, 1000.0);
}

void add_quality_options(cli::CommandLine& app, Typed& t) {
    app.add_option("--spp", t.options.spp, "Samples per pixel").between(1u, 1048576u).with_default();
    app.add_option("--samples", t.samples,
                   "even: as many everywhere; angle: fewer towards the poles, for equal noise in an eye")
        .one_of(sample_spreads)
        .with_default();
    cli::add_seed_option(app, t.options.seed, "Other seeds give independent noise");
    app.add_option("--denoise", t.denoise,
                   "Take the noise out of colour by Open Image Denoise (pip install pyoidn): quickly or well")
        .one_of(denoise_quality_names)
        .with_default();
    app.add_option("--accumulate", t.options.accumulate,
                   "Average each pixel with earlier frames, where anything moves with this many at most. 0: off")
        .between(0u, 1000u)
        .with_default();
    app.add_option(
           "--aovs", t.options.aovs,
           "depth,motion,normal,albedo,ids,specular,virtual, all or none; raw: colour before denoising; guides: albedo "
           "and normals for the denoiser; samples, variance: of accumulated pixels; reference: a few pixels "
           "with many samples, for the confidence map; cryptomatte: objects and materials by name")
        .with_default();
}

}  // namespace

std::vector<WindowGrid> window_grids(const RenderOptions& options) {
    std::vector<WindowGrid> grids;
    if (!options.window)
        return grids;
    const int sphere_columns = columns_as_dense_as(options.size);
    const auto is_useful = [&](const WindowGrid& grid) {
        return grid.columns > sphere_columns && std::min(grid.width, grid.height) >= min_track_side &&
               !window_grid_problem(grid);
    };
    grids.push_back(options.window->grid);
    for (int halvings = 1; options.follow && halvings <= most_window_halvings; ++halvings) {
        const WindowGrid grid = halved_window_grid(grids.front(), halvings);
        if (!is_useful(grid))
            break;
        grids.push_back(grid);
    }
    return grids;
}

const char* eye_name(es_eye eye) {
    static_assert(ES_EYE_CENTRE == static_cast<int>(Eye::centre) && ES_EYE_LEFT == static_cast<int>(Eye::left) &&
                  ES_EYE_RIGHT == static_cast<int>(Eye::right));
    return eye_names[eye];
}

std::function<RenderOptions()> add_render_options(cli::CommandLine& app, const HostText& host) {
    const auto typed = std::make_shared<Typed>();
    typed->host = host.name;
    app.add_option("scene", typed->options.scene, host.scene).required();
    app.add_option("--out", typed->options.out, "Folder for the frames: one sub-folder per eye").required();
    app.add_option("--host", typed->host, "Renderer: embree or mitsuba; this is the help of the one shown")
        .offers(std::array{host.name})
        .with_default();
    add_camera_options(app, *typed);
    add_frame_options(app, *typed);
    add_quality_options(app, *typed);
    app.add_option("--threads", typed->options.threads, "Rendering threads (default: one per processor)")
        .between(1u, 1024u);
    app.add_flag("--overwrite", typed->options.overwrite,
                 "Render finished frames again, and replace frames of other settings");
    app.add_flag("--single-part", typed->options.single_part, "EXR files with one part, for readers of the first only");
    cli::add_progress_option(app, typed->progress);
    app.add_flag("--follow", typed->options.follow,
                 "Stay, and render each frame that a line of standard input asks for (docs/guide/render.md, \"Frames "
                 "on demand\")");
    app.add_flag("--dry-run", typed->options.dry_run,
                 "Render nothing: check all options, and say what would be rendered");
    cli::add_json_flag(app, typed->options.json);
    return [typed, own = host.name] { return checked(*typed, own); };
}

FrameTimes Timeline::times(std::int64_t index) const {
    const std::int64_t previous = index > 0 ? index - 1 : index;
    const std::int64_t next = index + 1 < path_frames ? index + 1 : index;
    return {index, time_s(previous), time_s(index), time_s(next)};
}

namespace {

void note_clock(const PosePath& path, const std::string& name) {
    const std::string note = clock_note(path, name);
    if (!note.empty())
        std::fprintf(stderr, "equistream render: note: %s\n", note.c_str());
}

/// What moves counts from the first sample of the scene's own camera, where that was recorded on the same clock.
void require_same_clock(const PosePath& path, const std::string& name, const MovingObject& moving) {
    const double theirs_s = moving.path.clock_start_s();
    if (path.clock_start_s() != 0 && theirs_s != 0 && path.clock_start_s() != theirs_s)
        throw InputError(expected_found(
            "--path " + name,
            formatted("a path that begins at %.6f s, as that of %s does", theirs_s, moving.object.c_str()),
            formatted("%.6f s", path.clock_start_s())));
}

}  // namespace

Timeline make_timeline(const RenderOptions& options, const SceneDescription& scene) {
    Timeline t;
    t.path = options.path.empty() ? scene.camera_path : read_path_csv(options.path);
    if (t.path.empty())
        throw InputError(expected_found(scene.file.string(), "a camera path (or --path)", "none"));
    if (!options.path.empty())
        for (const MovingObject& moving : scene.moving)
            require_same_clock(t.path, options.path.string(), moving);
    note_clock(t.path, options.path.empty() ? "the camera path of " + scene.file.string() : options.path.string());
    for (const MovingObject& moving : scene.moving)
        if (moving.path.clock_start_s() != scene.camera_path.clock_start_s())
            note_clock(moving.path, "the path of " + moving.object);
    t.frames_per_second = options.frames_per_second.value_or(scene.frames_per_second);
    // The small term keeps a last key that falls on a frame from being lost to rounding.
    t.path_frames = static_cast<std::int64_t>(std::floor(t.path.duration_s() * t.frames_per_second + 1e-6)) + 1;
    t.range = options.frames.value_or(cli::FrameRange{0, t.path_frames - 1});
    if (t.range.last >= t.path_frames)
        throw InputError(
            expected_found("--frames",
                           options.path.empty() && t.path_frames == 1
                               ? "0, the only frame of the camera's path (--path CSV gives it a longer one)"
                               : "frames within the path's 0-" + std::to_string(t.path_frames - 1),
                           std::to_string(t.range.first) + "-" + std::to_string(t.range.last)));
    return t;
}

}  // namespace equistream::render_command
