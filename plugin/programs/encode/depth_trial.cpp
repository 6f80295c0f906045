#include "depth_trial.h"

#include <equistream/bound.h>
#include <equistream/colour.h>
#include <equistream/error.h>
#include <equistream/sequence.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace equistream {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t trial_frames = 8;
constexpr int worst_crf = 51;

/// So few pixels beyond the bound that no more bits are worth it.
constexpr double enough_within = 0.9999;

class ScratchFolder {
public:
    ScratchFolder() {
        std::string name = (fs::temp_directory_path() / "equistream-encode-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr)
            throw WorkError(name + ": no folder for trials could be made there");
        path_ = name;
    }
    ~ScratchFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    std::string file() const { return (path_ / "trial.nut").string(); }

private:
    fs::path path_;
};

struct TrialFrame {
    FrameInfo info;
    ByteImage rgb;
    FloatImage depth_m;
};

/// The start of the group in the middle.
std::vector<TrialFrame> read_frames(const DepthTrack& track, const std::vector<std::int64_t>& frames, int gop) {
    const std::size_t groups = (frames.size() + std::size_t(gop) - 1) / std::size_t(gop);
    const std::size_t first = groups / 2 * std::size_t(gop);
    std::vector<std::string> planes = planes_of(track.role);
    planes.push_back("colour");
    const DisplayTransform display;
    DepthRanges ranges(track, frames, gop);
    std::vector<TrialFrame> read;
    for (std::size_t i = first; i < std::min(first + trial_frames, frames.size()); ++i) {
        const fs::path file = track.source.folder / frame_file_name(frames[i]);
        Frame frame = read_exr(file, planes);
        frame.info.index = frames[i];
        frame.info.depth_code = DepthCodeInfo{track.code, ranges.of(i), 0};
        read.push_back({frame.info,
                        quantise_8bit(display.to_display(frame.planes.at("colour").view(), frame.info.exposure).view()),
                        distances_to_code(track, frame, file)});
    }
    return read;
}

class Trials {
public:
    Trials(const DepthTrack& track, const Sources& sources, const StreamSettings& settings)
        : track_(track), settings_(settings), frames_(read_frames(track, sources.frames, settings.gop)) {
        settings_.pictures = std::uint32_t(frames_.size());
        settings_.frames_per_second = frames_.front().info.frames_per_second;
        colour_bytes_ = colour_bytes();
    }

    DepthTrial with(double crf) const {
        StreamSettings settings = settings_;
        const FloatImage& first = frames_.front().depth_m;
        settings.tracks = {{track_.role, first.width(), first.height(), track_.code, crf}};
        StreamWriter writer(scratch_.file(), settings);
        for (const TrialFrame& frame : frames_)
            writer.write_depth(track_.role, frame.depth_m.view(), frame.info);
        writer.finish();
        return {crf, double(writer.bytes().front()) / double(frames_.size()), colour_bytes_, share_within_budget(),
                int(frames_.size())};
    }

private:
    double colour_bytes() const {
        StreamSettings settings = settings_;
        const ByteImage& first = frames_.front().rgb;
        settings.tracks = {{TrackRole::main, first.width(), first.height()}};
        StreamWriter writer(scratch_.file(), settings);
        for (const TrialFrame& frame : frames_) {
            FrameInfo info = frame.info;
            info.depth_code.reset();
            writer.write(TrackRole::main, frame.rgb.view(), info);
        }
        writer.finish();
        return double(writer.bytes().front()) / double(frames_.size());
    }

    double share_within_budget() const {
        const double budget_rad = error_budget_rad(default_focal_length_px);
        StreamReader reader(scratch_.file());
        std::int64_t within = 0, pixels = 0;
        for (const TrialFrame& frame : frames_) {
            const auto decoded = reader.next();
            if (!decoded || decoded->depth_m.samples().size() != frame.depth_m.samples().size())
                throw WorkError("a trial of depth could not be read back");
            for (std::size_t i = 0; i < frame.depth_m.samples().size(); ++i) {
                const float r = frame.depth_m.samples()[i], used = decoded->depth_m.samples()[i];
                within += std::isnan(r) ? std::isnan(used)
                                        : displacement_bound_rad(r, used, track_.box_radius_m) <= budget_rad;
            }
            pixels += std::int64_t(frame.depth_m.samples().size());
        }
        return double(within) / double(pixels);
    }

    DepthTrack track_;
    StreamSettings settings_;
    ScratchFolder scratch_;
    std::vector<TrialFrame> frames_;
    double colour_bytes_ = 0;
};

}  // namespace

DepthTrial try_track(const DepthTrack& track, const Sources& sources, const StreamSettings& settings) {
    return Trials(track, sources, settings).with(track.crf.value_or(settings.crf));
}

void choose_crf(const DepthRequest& request, const Sources& sources, const StreamSettings& settings, DepthPlan& plan) {
    if (request.crf || plan.tracks.empty() || plan.tracks.front().role != TrackRole::depth ||
        plan.tracks.front().code == DepthCodeId::lossless)
        return;
    const Trials trials(plan.tracks.front(), sources, settings);
    // Bytes fall as the CRF rises: the smallest within the share.
    int low = 0, high = worst_crf;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (trials.with(middle).share() <= request.share)
            high = middle;
        else
            low = middle + 1;
    }
    DepthTrial chosen = trials.with(low);
    while (chosen.within >= enough_within && chosen.crf < worst_crf) {
        const DepthTrial next = trials.with(chosen.crf + 1);
        if (next.within < enough_within)
            break;
        chosen = next;
    }
    plan.trial = chosen;
    for (DepthTrack& track : plan.tracks)
        track.crf = chosen.crf;
}

}  // namespace equistream
