#pragma once
/// One frame at a time: from what was received to both eyes' finished pictures, timed by stage.
#include "report.h"
#include "settings.h"

#include <client/pipeline/cpu_pipeline.h>
#include <client/pipeline/decisions.h>

#include <client/receive/receive.h>

#include <array>
#include <optional>
#include <vector>

namespace equistream::play {

/// One eye of one frame, and what its file is tagged with.
struct PlayedEye : PipelineEye {
    FrameInfo info;
};

struct PlayedFrame {
    PlayedEye left, right;
    FrameFigures figures;
    std::vector<FrameTimes> times;  ///< of each repetition
};

/// A refresh of a display, which shows the head where it is then and not where the frame was made for.
struct RefreshMoment {
    std::int64_t number = 0;
    double display_s = 0;
    double refresh_hz = 0;
    Pose head;
    double extrapolation_s = 0;  ///< what moves is shown so much later than in the frame, where the frame says how
};

class FramePlayer {
public:
    /// Reads the head's path and the scene's description.
    explicit FramePlayer(const Settings& settings);
    ~FramePlayer();

    /// Chooses method and depth by what came, and loads the scene's geometry where they need it; what was chosen goes
    /// into `report`. Throws InputError if these frames cannot be played as asked; what cannot be told becomes a note.
    void prepare(const ReceivedFrame& first, Report& report);
    /// For --method auto: finds what the budget allows, and says so in `report`. Before the first play. The frame that
    /// is timed is the second, which has one before it as all later ones have; null: there is only the first, which is
    /// timed too where the second lacks depth. From then on only tracks are needed that the choice needs.
    void settle(const ReceivedFrame& first, const ReceivedFrame* second, Report& report);
    /// Whether patches came whose depth neither the stream had nor OpenGL drew.
    bool missed_patch_depth() const { return pipeline_.missed_patch_depth(); }
    /// `played` keeps its memory from the frame before. At a refresh: of its number and time; what the frame shows
    /// stays as it was at the frame's own time, but for what moves. Where its depth is lost, eyes only turn.
    void play(const ReceivedFrame& frame, PlayedFrame& played, const RefreshMoment* refresh = nullptr);
    /// Where the head is, by the path that was given; there must be one.
    Pose head_at(double time_s) const { return head_path_.at(time_s); }
    /// For --method auto, between what was played last (nothing yet: no times) and frame `next`: whether that and those
    /// after it are played in another way. Tracks that are not decoded cannot be had in the middle of a stream, so
    /// there are only ways that need no other of those that came than the first choice; what they do not need is
    /// decoded all the same, and counts, so that they can be left again. Frames whose depth is lost do not count.
    void rechoose(const PlayedFrame& played, std::int64_t next, Report& report);
    /// The frame that was played last, for what later ones may take from it.
    void remember(ReceivedFrame&& frame);
    /// Each eye's, of frames as this one.
    PerspectiveCamera eye_camera(const FrameInfo& source) const;

private:
    DepthOffer offer(const ReceivedFrame& first) const;
    std::optional<Eye> eye_without_plane(const ReceivedFrame& first) const;
    void use(const Plan& plan);
    /// Of the plan, as far as the frame allows it.
    PipelineWays ways() const;
    void choose_ways_of(const ReceivedFrame& frame);
    /// Plays `timed` as it would be played after `before`.
    Trial measure(const Plan& plan, const ReceivedFrame* before, const ReceivedFrame& timed);
    /// `came`: what of the source did.
    std::vector<std::string> idle_passes(TrackRoles came) const;
    /// Forgets all frames but this one, which was played before those to come.
    void begin_after(const ReceivedFrame* before);
    /// What `geometry` fills from, where some chain may have that pass.
    void make_geometry();
    void check_size(const ReceivedFrame& first) const;
    void set_eyes(const ReceivedFrame& frame, PlayedFrame& played, const RefreshMoment* refresh = nullptr) const;
    FrameInfo eye_info(const ReceivedFrame& frame, Eye eye, const RefreshMoment* refresh = nullptr) const;
    /// Decoding, then conversion.
    std::array<double, 2> decoding_ms(const ReceivedFrame& frame) const;
    bool takes_depth() const { return gives_depth_ && plan_.depth != "none" && !lacks_depth_; }

    Settings settings_;
    Plan plan_;
    TrackRoles uncounted_;  ///< while ways are timed: tracks that came and would not be decoded
    std::optional<Rechooser> rechooser_;
    PosePath head_path_;
    std::optional<SceneDescription> scene_;
    bool gives_depth_ = false;  ///< there is a depth source
    bool lacks_depth_ = false;  ///< the depth of the frame that was played last is lost
    CpuPipeline pipeline_;
};

}  // namespace equistream::play
