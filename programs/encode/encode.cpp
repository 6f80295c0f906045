/// equistream encode: EXR sequences to H.264 or H.265.
#include "encode_sequence.h"

#include <equistream/bound.h>
#include <equistream/colour.h>
#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/text.h>
#include <plugin/export/frame_json.h>
#include <programs/cli/provenance.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>

namespace equistream {

namespace {

struct Options {
    EncodeRequest request;  ///< its numbers and names; what is chosen by a word is below, as typed
    SourceRequest sources;  ///< so too
    std::string command, eye, codec = "h264", transfer = "srgb", stereo = "tracks", fill = "auto", depth_scale = "auto",
                              mirrors = "auto", motion = "none", progress = "auto";
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

/// Ordinary players know of one picture a frame and of nothing that goes with it.
StereoPacking packing_of(const Options& options) {
    if (options.stereo == "tracks")
        return StereoPacking::none;
    const auto refuse = [&](bool given, const std::string& option) {
        cli::require(!given, "--stereo " + options.stereo, "both eyes as ordinary video, nothing beside it", option);
    };
    refuse(!options.eye.empty(), "--eye " + options.eye);
    refuse(options.fill != "auto" && options.fill != "none", "--fill " + options.fill);
    refuse(options.request.depth.code != "none", "--depth " + options.request.depth.code);
    refuse(options.mirrors == "always", "--mirrors always");
    refuse(options.motion != "none", "--motion " + options.motion);
    refuse(options.transfer != "srgb", "--transfer " + options.transfer);
    return options.stereo == "top-bottom" ? StereoPacking::top_bottom : StereoPacking::side_by_side;
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
    request.sources = find_sources(sources);
    request.depth = depth_request_of(options);
    request.motion = options.motion == "auto";
    cli::require(!request.motion || request.sources.looked_at().role == TrackRole::main, "--motion",
                 "none where a window was rendered: what moves is said of whole spheres", "auto");
    check_crf("--fill-crf", request.fill_crf);
    return request;
}

double megabits_per_second(const EncodedTrack& track, const EncodeReport& report) {
    const double seconds = report.settings.pictures / report.settings.frames_per_second;
    return 8e-6 * static_cast<double>(track.bytes) / seconds;
}

/// "9.3 %", "0.01 %": never 0 for what is not.
std::string percent_text(double share) {
    return formatted(share > 0 && share < 0.001 ? "%.1g %%" : "%.1f %%", 100 * share);
}

/// A depth track's may be another than the stream's.
Codec codec_of(const EncodedTrack& track, const EncodeReport& report) {
    return track.settings.codec(report.settings.codec);
}
const char* codec_name(Codec codec) {
    return codec == Codec::h264 ? "H.264" : "H.265";
}

/// A coded stream on standard output has it for itself.
bool is_standard_output(const std::string& target) {
    return target == "pipe:" || target == "pipe:1" || target == "/dev/stdout" || target == "/dev/fd/1" ||
           target == "/proc/self/fd/1";
}

double error_budget_of_stream_rad() {
    return error_budget_rad(default_focal_length_px);
}

/// What coded depth loses beside exact depth, as measured in five scenes (docs/results/reproject/depth_codes.md), and
/// what to do about it.
struct Judgement {
    double min_within;  ///< share of pixels within the budget
    const char* word;
    const char* meaning;
};
constexpr std::array judgements = {
    Judgement{0.8, "fine", "at most 0.1 dB lost beside exact depth"},
    Judgement{0.4, "fair", "up to 0.3 dB lost beside exact depth; a larger --depth-share loses less"},
    Judgement{0, "poor",
              "decibels may be lost beside exact depth; take a larger --depth-share, or give clients the scene or a "
              "model of it"}};

const Judgement& judgement_of(const DepthTrial& trial) {
    return *std::ranges::find_if(judgements, [&](const Judgement& j) { return trial.within >= j.min_within; });
}

/// What was chosen for a depth track and what that costs.
nlohmann::json depth_json(const EncodedTrack& track, const EncodeReport& report) {
    nlohmann::json json = {{"code", depth_code_name(*track.settings.depth_code)},
                           {"scale", track.settings.halved ? 2 : 1},
                           {"box_radius_m", track.range->box_radius_m},
                           {"near_m", track.range->near_m},
                           {"bound_in_budgets", track.bound_rad / error_budget_of_stream_rad()},
                           {"clamped_pixels", track.clamped_pixels},
                           {"crf", cli::or_null(track.settings.crf)}};
    if (report.trial && track.settings.role == TrackRole::depth)
        json["trial"] = {{"frames", report.trial->frames},
                         {"share_of_colour", report.trial->share()},
                         {"share_allowed", report.trial->allowed},
                         {"pixels_within_budget", report.trial->within},
                         {"judgement", judgement_of(*report.trial).word}};
    return json;
}

std::string trial_text(const DepthTrial& trial) {
    const Judgement& judgement = judgement_of(trial);
    return formatted("        in a trial of %d frames that took %s of the colour's bits and left %.2f %% of pixels "
                     "within the budget of %g px\n        that is %s: %s\n",
                     trial.frames, percent_text(trial.share()).c_str(), 100 * trial.within, default_error_budget_px,
                     judgement.word, judgement.meaning);
}

std::string depth_text(const EncodedTrack& track, const EncodeReport& report) {
    std::string text = formatted(
        "        coded as %s from %.3f m on around a head box of %.4f m: within %.2f of the error budget before "
        "the codec",
        depth_code_name(*track.settings.depth_code), track.range->near_m, track.range->box_radius_m,
        track.bound_rad / error_budget_of_stream_rad());
    if (track.settings.depth_code == DepthCodeId::lossless)
        text = "        coded without loss";
    if (track.settings.halved)
        text += ", the nearest of each four pixels";
    if (track.settings.depth_code != DepthCodeId::lossless && track.settings.crf)
        text += formatted(", CRF %g", *track.settings.crf);
    text += "\n";
    if (report.trial && track.settings.role == TrackRole::depth)
        text += trial_text(*report.trial);
    if (track.clamped_pixels > 0)
        text += formatted("        %lld pixels lay nearer and were coded as %.3f m\n",
                          static_cast<long long>(track.clamped_pixels), track.range->near_m);
    return text;
}

nlohmann::json motion_json(const EncodeReport& report) {
    if (!report.motion)
        return nullptr;
    const MotionTotals& motion = *report.motion;
    return {{"frames", motion.frames},
            {"most_regions", motion.max_regions},
            {"regions_left_out", motion.left_out},
            {"bytes", motion.bytes},
            {"share_of_colour", double(motion.bytes) / double(report.tracks.front().bytes)},
            {"horizon_s", extrapolation_horizon_s},
            {"mean_motion_px", motion.mean_motion_px},
            {"mean_error_px", motion.mean_error_px},
            {"worst_p95_error_px", motion.worst_p95_error_px}};
}

std::string motion_text(const EncodeReport& report) {
    const MotionTotals& motion = *report.motion;
    if (motion.frames == 0)
        return "  nothing moves by itself, or nobody can tell: no motion\n";
    std::string text = formatted(
        "  motion of up to %lld bodies in %lld frames: %.0f bytes a frame, %s of the colour's\n"
        "        of %.1f px that they move in %g s, %.3f px are left on average (at a focal length of %g px)\n",
        static_cast<long long>(motion.max_regions), static_cast<long long>(motion.frames),
        double(motion.bytes) / report.settings.pictures,
        percent_text(double(motion.bytes) / double(report.tracks.front().bytes)).c_str(), motion.mean_motion_px,
        extrapolation_horizon_s, motion.mean_error_px, default_focal_length_px);
    if (motion.left_out > 0)
        text +=
            formatted("        %lld bodies found no room in their frames\n", static_cast<long long>(motion.left_out));
    return text;
}

nlohmann::ordered_json as_json(const EncodeRequest& request, const Options& options, const EncodeReport& report) {
    const double count = report.settings.pictures;
    nlohmann::json tracks = nlohmann::json::array();
    for (const EncodedTrack& track : report.tracks) {
        tracks.push_back({{"name", track_name(track.settings.role)},
                          {"folder", track.folder.string()},
                          {"width", track.settings.width},
                          {"height", track.settings.height},
                          {"codec", codec_of(track, report) == Codec::h264 ? "h264" : "h265"},
                          {"bytes", track.bytes},
                          {"crf", cli::or_null(track.settings.coded_crf(report.settings.crf))},
                          {"bytes_per_frame", static_cast<double>(track.bytes) / count},
                          {"megabits_per_second", megabits_per_second(track, report)}});
        if (track.settings.depth_code)
            tracks.back()["depth_code"] = depth_json(track, report);
    }
    nlohmann::ordered_json json = cli::provenance(options.command);
    json.update(nlohmann::ordered_json{
        {"file", request.target},
        {"codec", options.codec},
        {"crf", report.settings.crf},
        {"preset", report.settings.preset},
        {"gop", report.settings.gop},
        {"transfer", options.transfer},
        {"view", options.transfer == "pq" ? nlohmann::json() : nlohmann::json(default_view)},
        {"exposure", report.first.exposure},
        {"scene", report.first.scene},
        {"full_sphere", report.settings.full_sphere},
        {"stereo", options.stereo},
        {"sphere_tag", report.sphere_tag},
        {"frames_per_second", report.settings.frames_per_second},
        {"frames",
         {{"first", request.sources.frames.front()},
          {"last", request.sources.frames.back()},
          {"count", report.settings.pictures}}},
        {"left_out", request.sources.left_out},
        {"not_finite_samples", report.not_finite_samples},
        {"coding_loss", report.colour.loss ? nlohmann::json{{"frames", report.colour.frames},
                                                            {"by_texture", coding_loss_to_json(*report.colour.loss)}}
                                           : nlohmann::json()},
        {"tracks", tracks},
        {"mirrors_left_out_share", cli::or_null(report.images_left_out_share)},
        {"motion", motion_json(report)},
        {"ms_per_frame",
         {{"read", report.read_ms / count},
          {"motion", report.motion_ms / count},
          {"display", report.display_ms / count},
          {"encode", report.encode_ms / count},
          {"wall", report.wall_ms / count}}}});
    return json;
}

/// Of a render with both eyes: what a client makes of the one that is sent, and how to send the other.
std::string left_out_text(const Sources& sources) {
    return formatted("  %s/ is left out: clients make both eyes of %s by depth (--eye %s sends that instead, --stereo "
                     "top-bottom both as ordinary video)\n",
                     in_a_sentence(sources.left_out, "/, ").c_str(), sources.tracks.front().folder.string().c_str(),
                     sources.left_out.front().c_str());
}

void print_text(const EncodeRequest& request, const Options& options, const EncodeReport& report, std::FILE* out) {
    const double count = report.settings.pictures;
    std::fprintf(out, "%s: frames %lld-%lld, %s CRF %g, preset %s, key frame every %d, %g frames/s%s\n",
                 request.target.c_str(), static_cast<long long>(request.sources.frames.front()),
                 static_cast<long long>(request.sources.frames.back()), codec_name(report.settings.codec),
                 report.settings.crf, report.settings.preset.c_str(), report.settings.gop,
                 report.settings.frames_per_second, report.sphere_tag ? ", tagged as 360 degree video" : "");
    if (report.settings.stereo != StereoPacking::none)
        std::fprintf(out, "  both eyes in one picture, %s, without poses: for ordinary players\n",
                     options.stereo.c_str());
    if (report.settings.transfer == Transfer::pq)
        std::fprintf(out, "  exposure %g, HDR: PQ (white at %g nits) BT.2020 4:2:0, 10 bits\n", report.first.exposure,
                     pq_white_nits);
    else
        std::fprintf(out, "  view %s, exposure %g, sRGB BT.709 4:2:0\n", default_view, report.first.exposure);
    for (const EncodedTrack& track : report.tracks) {
        const Codec codec = codec_of(track, report);
        const std::string other = codec == report.settings.codec ? "" : std::string(codec_name(codec)) + ", ";
        std::fprintf(out, "  %-5s %dx%d from %s: %s%.0f bytes a frame, %.3f Mbit/s\n", track_name(track.settings.role),
                     track.settings.width, track.settings.height, track.folder.string().c_str(), other.c_str(),
                     static_cast<double>(track.bytes) / count, megabits_per_second(track, report));
        if (track.settings.depth_code)
            std::fputs(depth_text(track, report).c_str(), out);
    }
    if (report.motion)
        std::fputs(motion_text(report).c_str(), out);
    if (!request.sources.left_out.empty())
        std::fprintf(out, "%s", left_out_text(request.sources).c_str());
    if (!report.not_measured.empty())
        std::fprintf(out, "  what coding takes was not measured, so that clients go by the CRF: %s\n",
                     report.not_measured.c_str());
    if (report.images_left_out_share)
        std::fprintf(out,
                     "  no track of mirrors and glass, which would take %s of the colour's bits (--mirrors always "
                     "sends it)\n",
                     percent_text(*report.images_left_out_share).c_str());
    if (report.trial && report.trial->share() > report.trial->allowed)
        std::fprintf(out, "  depth takes more than the %s asked for even at its worst\n",
                     percent_text(report.trial->allowed).c_str());
    std::fprintf(out,
                 "  ms a frame: read %.1f, display transform %.1f, encode %.1f; %.1f in all, reading beside encoding\n",
                 report.read_ms / count, report.display_ms / count, report.encode_ms / count, report.wall_ms / count);
    if (report.not_finite_samples > 0)
        std::fprintf(out, "  %lld samples were not finite and became black or white\n",
                     static_cast<long long>(report.not_finite_samples));
}

void run(const Options& options) {
    const cli::ProgressStyle style = cli::parse_progress(options.progress);
    const EncodeRequest request = request_of(options);
    EncodeReport report;
    {
        cli::Progress progress("encode", static_cast<double>(request.sources.frames.size()), style);
        report = encode_sequence(request, [&](std::size_t done) {
            progress.step(static_cast<double>(done), "frame " + std::to_string(request.sources.frames[done - 1]));
        });
    }
    std::FILE* out = is_standard_output(request.target) ? stderr : stdout;
    if (options.json)
        std::fprintf(out, "%s\n", json_text(as_json(request, options, report), 2).c_str());
    else
        print_text(request, options, report, out);
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
    cli::add_with_default(app, "--preset", request.settings.preset,
                          "ultrafast, superfast, veryfast, faster, fast, medium, slow, slower, veryslow or placebo");
    cli::add_with_default(app, "--gop", request.settings.gop, "Frames from one key frame to the next, 1 to 10000");
    app.add_option("--eye", options.eye, "Which folder is the main stream: centre, left or right (the first there is)")
        .one_of({"centre", "left", "right"});
    cli::add_with_default(
        app, "--stereo", options.stereo,
        "For ordinary 360 players: top-bottom (left/'s eye above right/'s, what most of them know) or "
        "side-by-side, one video without poses; tracks: what the client plays",
        {"tracks", "top-bottom", "side-by-side"});
    cli::add_frames_option(app, options.sources.frames, "FIRST-LAST or one number (default: all there are)");
    cli::add_with_default(app, "--fill", options.fill,
                          "Gap filling streams: auto (those that are there), none, or some of small, hidden, patches");
    app.add_option("--fill-crf", request.fill_crf,
                   "Quality of these streams' colour, 0 to 51 (default: --crf + 12; of small --crf + 8)");
    cli::add_with_default(
        app, "--depth", request.depth.code,
        "Depth beside main's colour, for clients without the scene: none, auto (code and bits from the error "
        "bound and --depth-share), w8, w10, w12, pece444, pece420, hue or lossless");
    app.add_option("--depth-share", request.depth.share,
                   "Of the main stream's bits that depth may take, all its tracks together; mirrors and glass as much "
                   "again: above 0, at most 1 (default: 0.1, up to 0.3 where that leaves less than 40 % of pixels "
                   "within the error bound)");
    cli::add_with_default(
        app, "--depth-scale", options.depth_scale,
        "1: depth of every pixel of main; 2: of the nearest of each four, for the bytes of fewer samples; "
        "auto: what leaves more pixels within the error bound at --depth-share (1 with --depth-crf)",
        {"1", "2", "auto"});
    app.add_option("--depth-crf", request.depth.crf,
                   "Quality of depth, hidden layers' and mirrors' too, 0 to 51, rather than by --depth-share");
    cli::add_with_default(
        app, "--mirrors", options.mirrors,
        "A track of how far away what main's mirrors and glass show is: auto (where it takes no more of the "
        "colour's bits than --depth-share), always or none",
        {"auto", "always", "none"});
    cli::add_with_default(
        app, "--motion", options.motion,
        "auto: what moves by itself, by more than the error bound, with main's pictures, from the AOVs "
        "backward, forward and depth, so that clients can carry it on while frames are late; or none",
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
