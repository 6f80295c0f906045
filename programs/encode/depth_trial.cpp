#include "depth_tracks.h"

#include <equistream/bound.h>
#include <equistream/error.h>
#include <equistream/sequence.h>
#include <programs/cli/process.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>

namespace equistream {

namespace {

namespace fs = std::filesystem;

/// So few pixels beyond the bound that no more bits are worth it.
constexpr double enough_within = 0.9999;
/// With fewer of them decibels are lost (docs/results/window.md), so that depth gets a larger share.
constexpr double min_share_within = 0.4;
/// More of them that a larger share is worth.
constexpr double min_gain = 0.05;

/// Beyond it bytes hardly fall any more, and surfaces leave their places: in san-miguel CRF 51 in place of 42 saved an
/// eighth of a stream and cost 7 dB (docs/results/window.md).
constexpr int coarsest_crf = 42;

/// Those of the colour's trial.
struct TrialFrames {
    TrialFrames(const DepthTrack& tried, const std::vector<std::int64_t>& frames, int gop)
        : track(tried), ranges(tried, frames, gop) {
        const TrialRange range(frames.size(), gop);
        first = range.first;
        const std::vector<std::string> planes = planes_of(track.role);
        for (std::size_t i = range.first; i < range.last; ++i) {
            const fs::path file = track.source.folder / frame_file_name(frames[i]);
            Frame frame = read_exr(file, planes);
            number_as_named(frame.info, frames[i]);
            distances_m.push_back(distances_to_code(track, frame, file));
            infos.push_back(frame.info);
        }
    }

    DepthTrack track;
    DepthRanges ranges;
    std::size_t first = 0;  ///< where the first stands among all frames
    std::vector<FrameInfo> infos;
    std::vector<FloatImage> distances_m;
};

class Trials {
public:
    /// The first of `tracks` is the one that is judged by its pixels.
    Trials(std::span<const DepthTrack> tracks, const Beside& beside)
        : settings_(beside.settings), colour_bytes_(beside.colour.get().bytes),
          tiles_may_be_halved_(!beside.tile || can_be_halved(beside.tile->width, beside.tile->height)) {
        if (!(colour_bytes_ > 0))
            throw InputError(expected_found(beside.sources.looked_at().folder.string(),
                                            "colour in the middle frames, to weigh depth's bits against", "none"));
        for (const DepthTrack& track : tracks)
            frames_.emplace_back(track, beside.sources.frames, settings_.gop);
        settings_.pictures = std::uint32_t(frames_.front().infos.size());
        settings_.frames_per_second = frames_.front().infos.front().frames_per_second;
    }

    DepthTrial with(const DepthWay& way, double crf) {
        double bytes = write(frames_.front(), way, crf);
        const double within = share_within_budget();
        for (std::size_t i = 1; i < frames_.size(); ++i)
            bytes += write(frames_[i], {frames_[i].track.code, frames_[i].track.halved}, crf);
        return {crf, bytes, colour_bytes_, within, int(settings_.pictures)};
    }

    /// At the least CRF whose bytes stay within the share, or coarsest_crf where none does; beyond that, as long as it
    /// leaves practically all pixels within the bound all the same.
    DepthTrial best(const DepthWay& way, double share) {
        DepthTrial chosen = min_within(way, share);
        chosen.allowed = share;
        while (chosen.within >= enough_within && chosen.crf < worst_crf) {
            DepthTrial next = with(way, chosen.crf + 1);
            next.allowed = share;
            if (next.within < enough_within)
                break;
            chosen = next;
        }
        guess_ = int(chosen.crf);
        return chosen;
    }

    /// All that the request leaves open for `main`, the first track.
    std::vector<DepthWay> ways(const DepthRequest& request) {
        TrialFrames& main = frames_.front();
        std::vector<DepthCodeId> codes = {main.track.code};
        if (request.code == "auto") {
            // Those that hold the nearest depths as well as the finest does. That one's encoder may be the better.
            const double nearest_m = main.ranges.of(main.first, {DepthCodeId::w12, false}).near_m;
            for (const DepthCodeId code : {DepthCodeId::w8, DepthCodeId::w10, DepthCodeId::w12})
                if (code != main.track.code && main.ranges.of(main.first, {code, false}).near_m <= nearest_m)
                    codes.push_back(code);
        }
        const FloatImage& depth_m = main.distances_m.front();
        const bool try_half = tiles_may_be_halved_ && can_be_halved(depth_m.width(), depth_m.height());
        std::vector<DepthWay> all;
        for (const DepthCodeId code : codes)
            for (const bool halved : {false, true})
                if (halved == request.halved.value_or(halved && try_half))
                    all.push_back({code, halved});
        return all;
    }

private:
    /// Bytes fall as the CRF rises, by about half in six.
    DepthTrial min_within(const DepthWay& way, double share) {
        int low = 0, high = coarsest_crf;
        std::optional<DepthTrial> at_high;
        for (int next = guess_; low < high;) {
            const int crf = std::clamp(next, low, high - 1);
            const DepthTrial trial = with(way, crf);
            const double farther = 6 * std::log2(trial.share() / share);
            if (trial.share() <= share) {
                high = crf;
                at_high = trial;
                next = int(std::floor(crf + farther));
            } else {
                low = crf + 1;
                next = int(std::ceil(crf + farther));
            }
        }
        return at_high ? *at_high : with(way, high);
    }

    double write(TrialFrames& frames, const DepthWay& way, double crf) const {
        StreamSettings settings = settings_;
        const FloatImage& first = frames.distances_m.front();
        settings.tracks = {{frames.track.role, first.width(), first.height(), way.code, crf, way.halved}};
        StreamWriter writer(scratch_.file("trial.nut"), settings);
        for (std::size_t i = 0; i < frames.infos.size(); ++i) {
            FrameInfo info = frames.infos[i];
            info.depth_code = DepthCodeInfo{way.code, frames.ranges.of(frames.first + i, way), 0};
            writer.write_depth(frames.track.role, frames.distances_m[i].view(), info);
        }
        writer.finish();
        return double(writer.bytes().front()) / double(frames.infos.size());
    }

    /// Of the first track, as it was written last.
    double share_within_budget() const {
        const TrialFrames& frames = frames_.front();
        const double budget_rad = error_budget_rad(default_focal_length_px);
        StreamReader reader(scratch_.file("trial.nut"));
        std::int64_t within = 0, pixels = 0;
        for (const FloatImage& distances_m : frames.distances_m) {
            const auto decoded = reader.next();
            if (!decoded || decoded->depth_m.samples().size() != distances_m.samples().size())
                throw WorkError("the trial encoding of depth could not be decoded");
            for (std::size_t i = 0; i < distances_m.samples().size(); ++i) {
                const float r = distances_m.samples()[i], used = decoded->depth_m.samples()[i];
                within += std::isnan(r) ? std::isnan(used)
                                        : displacement_bound_rad(r, used, frames.track.box_radius_m) <= budget_rad;
            }
            pixels += std::int64_t(distances_m.samples().size());
        }
        return double(within) / double(pixels);
    }

    StreamSettings settings_;
    cli::ScratchFolder scratch_{"encode"};
    std::vector<TrialFrames> frames_;
    double colour_bytes_ = 0;
    bool tiles_may_be_halved_;
    int guess_ = 24;  ///< where to begin; then where the last way ended
};

bool is_better(const DepthTrial& a, const DepthTrial& b) {
    const bool a_fits = a.share() <= a.allowed, b_fits = b.share() <= b.allowed;
    if (a_fits != b_fits)
        return a_fits;
    if (!a_fits || (a.within >= enough_within && b.within >= enough_within))
        return a.bytes < b.bytes;
    return a.within > b.within;
}

struct Choice {
    DepthWay way;
    DepthTrial trial;
};

Choice best_of(Trials& trials, const std::vector<DepthWay>& ways, double share) {
    std::optional<Choice> best;
    for (const DepthWay& way : ways) {
        const DepthTrial trial = trials.best(way, share);
        if (!best || is_better(trial, best->trial))
            best = {way, trial};
    }
    return *best;
}

}  // namespace

DepthTrial try_track(const DepthTrack& track, const Beside& beside) {
    return Trials({&track, 1}, beside).with({track.code, track.halved}, track.crf.value_or(beside.settings.crf));
}

void choose_depth(const DepthRequest& request, const Beside& beside, DepthPlan& plan) {
    if (request.crf || plan.tracks.empty() || !may_be_halved(plan.tracks.front().role) ||
        plan.tracks.front().code == DepthCodeId::lossless)
        return;
    Trials trials(plan.tracks, beside);
    DepthTrack& main = plan.tracks.front();
    std::optional<Choice> chosen;
    for (const double share : request.shares()) {
        const Choice choice = best_of(trials, trials.ways(request), share);
        if (chosen && choice.trial.within < chosen->trial.within + min_gain)
            break;
        chosen = choice;
        if (chosen->trial.within >= min_share_within)
            break;
    }
    plan.trial = chosen->trial;
    main.code = chosen->way.code;
    main.halved = chosen->way.halved;
    for (DepthTrack& track : plan.tracks)
        track.crf = plan.trial->crf;
}

}  // namespace equistream
