/// equistream encode: EXR sequences to H.264 or H.265.
#include "encode_sequence.h"
#include "report.h"

#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/text.h>
#include <programs/cli/process.h>
#include <programs/cli/provenance.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>

namespace equistream {

namespace {

struct Options : AsTyped {
    EncodeRequest request;  ///< its numbers and names; what is chosen by a word is below, as typed
    SourceRequest sources;  ///< so too
    std::string eye, fill = "auto", depth_scale = "auto", mirrors = "auto", motion = "none", progress = "auto", tiles;
    std::optional<int> base_columns;
    bool json = false;
};

void check_crf(const char* option, const std::optional<double>& crf) {
    if (crf)
        cli::require(*crf >= 0 && *crf <= 51, option, "0 to 51", in_words(*crf));
}

DepthRequest depth_request_of(const Options& options) {
    DepthRequest depth = options.request.depth;
    if (depth.code != "auto" && depth.code != "none")
        try {
            make_depth_code(depth.code);
        } catch (const InputError& error) {
            throw InputError("--depth: auto, none or a " + std::string(error.what()));
        }
    if (depth.share)
        cli::require(*depth.share > 0 && *depth.share <= 1, "--depth-share",
                     "a share of the colour's bits above 0 and at most 1, 0.1 being 10 %", in_words(*depth.share));
    check_crf("--depth-crf", depth.crf);
    if (options.depth_scale != "auto")
        depth.halved = options.depth_scale == "2";
    depth.images = options.mirrors == "none"     ? ImagesTrack::none
                   : options.mirrors == "always" ? ImagesTrack::always
                                                 : ImagesTrack::if_cheap;
    return depth;
}

/// Both eyes in one picture have depth, and nothing else that goes with one eye's.
StereoPacking packing_of(const Options& options) {
    if (options.stereo == "tracks")
        return StereoPacking::none;
    const auto refuse = [&](bool given, const std::string& option) {
        cli::require(!given, "--stereo " + options.stereo, "only both eyes and their depth", option);
    };
    refuse(!options.eye.empty(), "--eye " + options.eye);
    refuse(options.fill != "auto" && options.fill != "none", "--fill " + options.fill);
    refuse(options.mirrors == "always", "--mirrors always");
    refuse(options.motion != "none", "--motion " + options.motion);
    refuse(options.transfer != "srgb", "--transfer " + options.transfer);
    return options.stereo == "top-bottom" ? StereoPacking::top_bottom : StereoPacking::side_by_side;
}

/// Nothing where the sphere is sent whole.
std::optional<TileRequest> tiles_of(const Options& options) {
    cli::require(!options.tiles.empty() || !options.base_columns, "--base", "--tiles as well", "no tiles");
    if (options.tiles.empty())
        return std::nullopt;
    const cli::Size counts = cli::parse_size(options.tiles, "--tiles");
    return TileRequest{{counts.width, counts.height}, options.base_columns};
}

/// What goes along each pixel of the whole sphere has no place beside tiles.
void check_beside_tiles(const EncodeRequest& request, const Options& options) {
    const std::string option = "--tiles " + options.tiles;
    cli::require(options.stereo == "tracks", option, "--stereo tracks", options.stereo);
    cli::require(!request.motion, option, "--motion none, as motion is coded for whole spheres only", options.motion);
    for (const SourceTrack& track : request.sources.tracks)
        cli::require(track.role == TrackRole::main || track.role == TrackRole::small, option,
                     "a whole sphere with a small stream at most (--fill none or small)",
                     std::string(track_name(track.role)) + " in " + track.folder.string());
}

EncodeRequest request_of(const Options& options) {
    EncodeRequest request = options.request;
    request.settings.codec = options.codec == "h264" ? Codec::h264 : Codec::h265;
    request.settings.transfer = options.transfer == "pq" ? Transfer::pq : Transfer::srgb;
    check_coding(request.settings, "--");
    SourceRequest sources = options.sources;
    sources.fill = parse_fill_tracks(options.fill);
    if (!options.eye.empty())
        sources.eye = options.eye;
    sources.packing = packing_of(options);
    request.tiles = tiles_of(options);
    if (request.tiles && sources.fill.automatic)
        sources.fill = {false, {}};
    request.sources = find_sources(sources);
    request.depth = depth_request_of(options);
    request.motion = options.motion == "auto";
    cli::require(!request.motion || request.sources.looked_at().role == TrackRole::main, "--motion",
                 "none for a render with a window, as motion is coded for whole spheres only", "auto");
    check_crf("--fill-crf", request.fill_crf);
    const auto fills_gaps = [](const SourceTrack& track) {
        return track.role != TrackRole::main && track.role != TrackRole::window;
    };
    cli::require(!request.fill_crf || std::ranges::any_of(request.sources.tracks, fills_gaps), "--fill-crf",
                 "tracks that fill gaps (--fill)", "none");
    if (request.tiles)
        check_beside_tiles(request, options);
    return request;
}

/// A coded stream on standard output has it for itself. As libav takes it: what is no number is standard output.
bool is_standard_output(const std::string& target) {
    constexpr std::string_view scheme = "pipe:";
    return target.starts_with(scheme) && parsed_number(target.substr(scheme.size())).value_or(1) == 1;
}

void run(const Options& options) {
    const cli::ProgressStyle style = cli::parse_progress(options.progress);
    const EncodeRequest request = request_of(options);
    require_replaceable_stream(request.target);
    cli::say_at_interrupt("equistream encode: interrupted before the first frame was coded");
    EncodeReport report;
    {
        std::optional<cli::Progress> progress;  // from the first frame on: trials of depth take what they take
        const std::size_t frames = request.sources.frames.size();
        report = encode_sequence(request, [&](std::size_t done) {
            if (!progress) {
                progress.emplace("encode", static_cast<double>(frames), style);
                cli::note_interrupts();
            }
            if (done > 0)
                progress->step(static_cast<double>(done), "frame " + std::to_string(request.sources.frames[done - 1]));
            if (cli::interrupted() && done < frames)
                throw WorkError("interrupted: " + std::to_string(done) + " of " + std::to_string(frames) +
                                " frames are coded");
        });
    }
    std::FILE* out = is_standard_output(request.target) ? stderr : stdout;
    if (options.json)
        std::fprintf(out, "%s\n", json_text(encode_json(request, options, report), 2).c_str());
    else
        print_report(request, options, report, out);
}

std::function<void()> set_up(cli::CommandLine& app, Options& options) {
    EncodeRequest& request = options.request;
    app.add_option("DIR", options.sources.folder, "A render's folder (centre/, left/, right/, small/), or one of these")
        .required();
    app.add_option("--out", request.target, "File (.mp4 .mkv .ts .nut .h264 .h265) or URL").required();
    cli::add_with_default(app, "--codec", options.codec,
                          "h264 or h265; depth as w12, hue or lossless is coded as h265 always", {"h264", "h265"});
    cli::add_with_default(
        app, "--transfer", options.transfer,
        "srgb: display-referred, clipped at white, 8 bits; pq: HDR, highlights up to 49 times white kept, 10 "
        "bits",
        {"srgb", "pq"});
    cli::add_with_default(app, "--crf", request.settings.crf, "Quality: 0 (best) to 51");
    cli::add_with_default(app, "--preset", request.settings.preset, "The encoder's: the slower, the fewer bytes")
        .offers(std::array{"ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow", "slower",
                           "veryslow", "placebo"});
    cli::add_with_default(app, "--gop", request.settings.gop, "Frames from one key frame to the next, 1 to 10000");
    app.add_option("--eye", options.eye, "Which folder is the main stream: centre, left or right (the first there is)")
        .one_of({"centre", "left", "right"});
    cli::add_with_default(app, "--stereo", options.stereo,
                          "Spheres of the stream\n"
                          "tracks        one eye's; clients make both eyes' views by depth\n"
                          "top-bottom    both eyes' in one picture, left/ above right/, which most 360 players know\n"
                          "side-by-side  both eyes' in one picture, left/ beside right/",
                          {"tracks", "top-bottom", "side-by-side"});
    cli::add_frames_option(app, options.sources.frames, "FIRST-LAST or one number (default: all there are)");
    cli::add_with_default(app, "--fill", options.fill,
                          "Gap filling streams: auto (those that are there), none, or some of small, hidden, patches");
    app.add_option("--fill-crf", request.fill_crf,
                   "Quality of these streams' colour, 0 to 51 (default: --crf + 12; of small --crf + 8)");
    cli::add_with_default(
        app, "--depth", request.depth.code,
        "Depth beside main's colour, for clients without the scene: none, auto (code and bits from the error "
        "bound and --depth-share), or a code")
        .offers(std::array{"none", "auto", "w8", "w10", "w12", "pece444", "pece420", "hue", "lossless"});
    app.add_option("--depth-share", request.depth.share,
                   "Share of the main stream's bits that depth may take, together with the tracks of mirrors and "
                   "glass: above 0, at most 1. Default: 0.1; for depth up to 0.3 where 0.1 leaves less than 40 % of "
                   "pixels within the error bound");
    cli::add_with_default(app, "--depth-scale", options.depth_scale,
                          "1: the depth of every pixel. 2: the nearest depth of every 2x2 pixels, for fewer bytes. "
                          "auto: the one with more pixels within the error bound at --depth-share (1 with --depth-crf)",
                          {"1", "2", "auto"});
    app.add_option("--depth-crf", request.depth.crf,
                   "Quality of depth, also of hidden layers and mirrors, 0 to 51, instead of --depth-share");
    cli::add_with_default(app, "--mirrors", options.mirrors,
                          "A track with the depth of virtual images in mirrors and glass. auto: only if its share of "
                          "the colour's bits is at most --depth-share",
                          {"auto", "always", "none"});
    app.add_option(
        "--tiles", options.tiles,
        "CxR, such as 8x4: cuts the sphere into C columns and R rows of tiles. Each tile is a track of its own; a "
        "coarser sphere lies around them (--base). serve sends each viewer the tiles that it looks at. Tiles are at "
        "least 64 pixels wide and high, in multiples of 16");
    app.add_option("--base", options.base_columns,
                   "Columns of the coarser sphere around tiles (default: a sixth of the whole sphere's)");
    cli::add_with_default(
        app, "--motion", options.motion,
        "auto: send the motion of objects that move by more than the error bound, so that clients can extrapolate them "
        "while frames are late. It is found from the AOVs backward, forward and depth",
        {"auto", "none"});
    cli::add_json_flag(app, options.json)
        .description("Report as JSON on standard output (on standard error where the video goes there)");
    cli::add_progress_option(app, options.progress);
    return [&options] { run(options); };
}

}  // namespace

}  // namespace equistream

int main(int argc, char** argv) {
    equistream::Options options;
    options.command = equistream::cli::quoted_command(argc, argv);
    return equistream::cli::run_program(
        argc, argv,
        {"encode", "Encode rendered frames as H.264 or H.265 video",
         "equistream encode out/sponza --out sponza.mkv --codec h265 --crf 20 --depth auto"},
        [&](equistream::cli::CommandLine& app) { return equistream::set_up(app, options); });
}
