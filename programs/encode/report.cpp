#include "report.h"

#include <equistream/bound.h>
#include <equistream/colour.h>
#include <equistream/text.h>
#include <plugin/export/frame_json.h>
#include <programs/cli/provenance.h>

#include <algorithm>
#include <array>

namespace equistream {

namespace {

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

double error_budget_of_stream_rad() {
    return error_budget_rad(default_focal_length_px);
}

/// What coded depth loses beside exact depth, as measured in five scenes (docs/results/reproject/depth_codes.md) and
/// with windows (docs/results/window.md), and what to do about it.
struct Judgement {
    double min_within;  ///< share of pixels within the budget
    const char* word;
    const char* meaning;
};
constexpr std::array judgements = {
    Judgement{0.8, "fine", "at most 0.1 dB below exact depth"},
    Judgement{0.4, "fair", "up to 0.3 dB below exact depth; a larger --depth-share loses less"},
    Judgement{0, "poor",
              "may be decibels below exact depth; use a larger --depth-share, or give clients the scene or a "
              "model of it"}};

const Judgement& judgement_of(const DepthTrial& trial) {
    return *std::ranges::find_if(judgements, [&](const Judgement& j) { return trial.within >= j.min_within; });
}

/// Whether its depth is what was tried: of what eyes look at.
bool was_tried(const EncodedTrack& track, const EncodeReport& report) {
    const bool has_windows = std::ranges::any_of(
        report.tracks, [](const EncodedTrack& other) { return other.settings.role == TrackRole::window; });
    return report.trial && track.settings.role == (has_windows ? TrackRole::window_depth : TrackRole::depth);
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
    if (was_tried(track, report))
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
    if (track.settings.depth_code == DepthCodeId::pece420)
        text += ", at worst: where depths that share a sample differ";
    if (track.settings.depth_code == DepthCodeId::lossless)
        text = "        coded without loss";
    if (track.settings.halved)
        text += ", the nearest of each four pixels";
    if (track.settings.depth_code != DepthCodeId::lossless && track.settings.crf)
        text += formatted(", CRF %g", *track.settings.crf);
    text += "\n";
    if (was_tried(track, report))
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
        return "  no motion data: no moving objects found\n";
    std::string text = formatted(
        "  motion of up to %lld objects in %lld frames: %.0f bytes a frame, %s of the colour's\n"
        "        they move by %.1f px in %g s; extrapolation leaves %.3f px on average (focal length %g px)\n",
        static_cast<long long>(motion.max_regions), static_cast<long long>(motion.frames),
        double(motion.bytes) / report.settings.pictures,
        percent_text(double(motion.bytes) / double(report.tracks.front().bytes)).c_str(), motion.mean_motion_px,
        extrapolation_horizon_s, motion.mean_error_px, default_focal_length_px);
    if (motion.left_out > 0)
        text += formatted("        %lld objects did not fit into their frames' data\n",
                          static_cast<long long>(motion.left_out));
    return text;
}

/// Of a render with both eyes: what a client makes of the one that is sent, and how to send the other.
std::string left_out_text(const Sources& sources) {
    return formatted(
        "  %s/ is not encoded: clients make both eyes from %s by depth (--eye %s encodes that instead, --stereo "
        "top-bottom both)\n",
        in_a_sentence(sources.left_out, "/, ").c_str(), sources.tracks.front().folder.string().c_str(),
        sources.left_out.front().c_str());
}

}  // namespace

nlohmann::ordered_json encode_json(const EncodeRequest& request, const AsTyped& options, const EncodeReport& report) {
    const double count = report.settings.pictures;
    nlohmann::json tracks = nlohmann::json::array();
    for (const EncodedTrack& track : report.tracks) {
        tracks.push_back({{"name", track_name(track.settings.role)},
                          {"tiles", track.tiles},
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
        {"full_sphere", report.settings.sphere && report.settings.sphere->is_full_sphere()},
        {"stereo", options.stereo},
        {"posed", report.settings.tagged},
        {"sphere_tag", report.sphere_tag},
        {"frames_per_second", report.settings.frames_per_second},
        {"frames",
         {{"first", request.sources.frames.front()},
          {"last", request.sources.frames.back()},
          {"count", report.settings.pictures}}},
        {"left_out", request.sources.left_out},
        {"not_finite_samples", report.not_finite_samples},
        {"visible_loss", report.colour.loss ? nlohmann::json{{"frames", report.colour.frames},
                                                             {"by_texture", visible_loss_to_json(*report.colour.loss)}}
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

void print_report(const EncodeRequest& request, const AsTyped& options, const EncodeReport& report, std::FILE* out) {
    const double count = report.settings.pictures;
    std::fprintf(out, "%s: frames %lld-%lld, %s CRF %g, preset %s, key frame every %d, %g frames/s%s\n",
                 request.target.c_str(), static_cast<long long>(request.sources.frames.front()),
                 static_cast<long long>(request.sources.frames.back()), codec_name(report.settings.codec),
                 report.settings.crf, report.settings.preset.c_str(), report.settings.gop,
                 report.settings.frames_per_second, report.sphere_tag ? ", tagged as 360 degree video" : "");
    if (report.settings.stereo != StereoPacking::none)
        std::fprintf(out, "  both eyes in one picture, %s%s\n", options.stereo.c_str(),
                     report.settings.tagged ? "" : ", without poses: the eyes do not share one head pose");
    if (report.settings.transfer == Transfer::pq)
        std::fprintf(out, "  exposure %g, HDR: PQ (white at %g nits) BT.2020 4:2:0, 10 bits\n", report.first.exposure,
                     pq_white_nits);
    else
        std::fprintf(out, "  view %s, exposure %g, sRGB BT.709 4:2:0\n", default_view, report.first.exposure);
    for (const EncodedTrack& track : report.tracks) {
        const Codec codec = codec_of(track, report);
        const std::string other = codec == report.settings.codec ? "" : std::string(codec_name(codec)) + ", ";
        const std::string tiles = track.tiles == 1 ? "" : std::to_string(track.tiles) + " tiles of ";
        std::fprintf(out, "  %-5s %s%dx%d from %s: %s%.0f bytes a frame, %.3f Mbit/s\n",
                     track_name(track.settings.role), tiles.c_str(), track.settings.width, track.settings.height,
                     track.folder.string().c_str(), other.c_str(), static_cast<double>(track.bytes) / count,
                     megabits_per_second(track, report));
        if (track.settings.depth_code)
            std::fputs(depth_text(track, report).c_str(), out);
    }
    if (report.motion)
        std::fputs(motion_text(report).c_str(), out);
    if (!request.sources.left_out.empty())
        std::fprintf(out, "%s", left_out_text(request.sources).c_str());
    if (!report.not_measured.empty())
        std::fprintf(out, "  visible error not measured, so confidence maps rely on the CRF: %s\n",
                     report.not_measured.c_str());
    if (report.images_left_out_share)
        std::fprintf(out,
                     "  no track of mirrors and glass: it would take %s of the colour's bits (--mirrors always "
                     "adds it)\n",
                     percent_text(*report.images_left_out_share).c_str());
    const auto is_of_mirrors = [](const EncodedTrack& track) { return is_reflections(track.settings.role); };
    if (request.depth.images == ImagesTrack::always && std::ranges::none_of(report.tracks, is_of_mirrors))
        std::fprintf(out,
                     "  no track of mirrors and glass: none found in the sampled frames of %s (render "
                     "--aovs depth,specular,virtual)\n",
                     request.sources.looked_at().folder.string().c_str());
    if (report.trial && report.trial->share() > report.trial->allowed)
        std::fprintf(out, "  depth takes more than %s of the colour's bits: coarser depth would displace surfaces\n",
                     percent_text(report.trial->allowed).c_str());
    std::fprintf(
        out,
        "  ms a frame: read %.1f, display transform %.1f, encode %.1f; %.1f in all, as reading and encoding overlap\n",
        report.read_ms / count, report.display_ms / count, report.encode_ms / count, report.wall_ms / count);
    if (report.not_finite_samples > 0)
        std::fprintf(out, "  %lld samples were not finite and became black or white\n",
                     static_cast<long long>(report.not_finite_samples));
}

}  // namespace equistream
