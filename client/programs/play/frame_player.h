#pragma once
/// One frame at a time: from what was received to both eyes' finished pictures, timed by stage.
#include "depth_choice.h"
#include "frame_fill.h"
#include "report.h"
#include "settings.h"

#include <equistream_client/carry_on.h>
#include <equistream_client/depth_source.h>
#include <equistream_client/engine.h>
#include <equistream_client/ray_depth.h>
#include <equistream_client/receive.h>

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace equistream::play {

/// One eye of one frame.
struct PlayedEye {
    FrameInfo info;
    EyePicture picture;
    ByteImage gaps;      ///< as the source left them, before any fill
    FloatImage depth_m;  ///< empty where nothing needed it

    PerspectiveCamera camera() const { return std::get<PerspectiveCamera>(info.camera); }
    /// Of local geometry, or what the method found itself; empty where there is neither.
    ImageView<const float> depth_view() const {
        const FloatImage& plane = depth_m.empty() ? picture.depth_m : depth_m;
        return plane.empty() ? ImageView<const float>{} : plane.view();
    }
    EyeView view() const {
        return {camera(), info.camera_pose, depth_m.empty() ? ImageView<const float>{} : depth_m.view()};
    }
};

struct PlayedFrame {
    PlayedEye left, right;
    FrameFigures figures;
    std::vector<PartTimes> parts;  ///< what its time went into, for each repetition
};

/// A refresh of a display, which shows the head where it is then and not where the frame was made for.
struct RefreshMoment {
    std::int64_t number = 0;
    double display_s = 0;
    double refresh_hz = 0;
    Pose head;
    double moved_on_s = 0;  ///< what moves is shown so much later than in the frame, where the frame says how
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
    /// is timed is the second, which has one before it as all later ones have; null: there is only the first. From then
    /// on only tracks are needed that the choice needs.
    void settle(const ReceivedFrame& first, const ReceivedFrame* second, Report& report);
    /// Whether patches came whose depth neither the stream had nor OpenGL drew.
    bool missed_patch_depth() const { return missed_patch_depth_; }
    /// `played` keeps its memory from the frame before. At a refresh: of its number and time; what the frame shows
    /// stays as it was at the frame's own time, but for what moves.
    void play(const ReceivedFrame& frame, PlayedFrame& played, const RefreshMoment* refresh = nullptr);
    /// Where the head is, by the path that was given; there must be one.
    Pose head_at(double time_s) const { return head_path_.at(time_s); }
    /// For --method auto, between what was played last (nothing yet: no parts) and frame `next`: whether that and those
    /// after it are played in another way. Tracks that are not decoded cannot be had in the middle of a stream, so
    /// there are only ways that need no other of those that came than the first choice; what they do not need is
    /// decoded all the same, and counts, so that they can be left again.
    void rechoose(const PlayedFrame& played, std::int64_t next, Report& report);
    /// The frame that was played last, for what later ones may take from it.
    void remember(ReceivedFrame&& frame);

private:
    DepthOffer offer(const ReceivedFrame& first) const;
    std::optional<Eye> eye_without_plane(const ReceivedFrame& first) const;
    void use(const Plan& plan);
    /// Plays `timed` as it would be played after `before`.
    Trial measure(const Plan& plan, const ReceivedFrame* before, const ReceivedFrame& timed);
    /// `came`: what of the source did.
    std::vector<std::string> idle_rungs(TrackRoles came) const;
    /// Forgets all frames but this one, which was played before those to come.
    void begin_after(const ReceivedFrame* before);
    /// What `geometry` fills from, where some ladder may have that rung.
    void make_geometry();
    void use_fill(const std::string& rungs);
    bool takes_depth() const { return depth_ != nullptr && plan_.depth != "none"; }
    /// Whether depth is what came with the frames.
    bool takes_planes() const { return exact_ != nullptr && offers_depth_; }
    void make_depth_source(const FrameInfo& first, const std::string& depth, Report& report);
    void check_size(const ReceivedFrame& first) const;
    void check_scene(const FrameInfo& first, Report& report) const;
    FrameInfo eye_info(const ReceivedFrame& frame, Eye eye, const RefreshMoment* refresh = nullptr) const;
    PerspectiveCamera eye_camera(const FrameInfo& source) const;
    /// How much later than the frame shows them moving things are to be seen: 0 where nothing moves, or no depth says
    /// what they pass before.
    double carried_s(const ReceivedFrame& frame, const PlayedFrame& played, const RefreshMoment* refresh) const;
    /// Of the frame, by whoever gives depth at its time; of eyes so much later.
    void take_depths(const ReceivedFrame& frame, PlayedFrame& played);
    void set_frame_time(const ReceivedFrame& frame);
    void offer_exact_depth(const ReceivedFrame& frame);
    void cast_depths(const ReceivedFrame& frame, PlayedFrame& played);
    /// Of an atlas that came without; empty where no geometry is known.
    void cast_patches(const ReceivedPicture& patches, FloatImage& depth_m);
    void reproject_and_fill(const ReceivedFrame& frame, const SourceDepths& depths, PlayedFrame& played);
    /// The main picture, or what it was carried on to.
    SourceView main_view(const ReceivedFrame& frame, const PlayedFrame& played) const;

    /// All parts of plan_: decoding as it was timed, the others 0 so far.
    PartTimes parts_with_decoding(const ReceivedFrame& frame) const;
    /// Time of take_depths that went into one track's.
    void add_cast(std::string_view track, double ms) {
        parts_[part::depth(plan_)] -= ms;
        parts_[part::depth_of(plan_, track)] += ms;
    }
    /// Adds `ms` of filling to parts_, each rung's as its share of what all took.
    void add_filling(std::span<const double> left_ms, std::span<const double> right_ms, double ms);

    Settings settings_;
    Plan plan_;
    bool is_settled_ = false;  ///< what is decoded is decoded for good, and has to be counted
    PartTimes parts_;          ///< of the repetition under way
    std::optional<Rechooser> rechooser_;
    PosePath head_path_;
    std::optional<SceneDescription> scene_;
    std::unique_ptr<Engine> engine_;
    std::unique_ptr<DepthSource> depth_;
    ExactDepth* exact_ = nullptr;                              ///< depth_, where that is exact
    bool offers_depth_ = true;                                 ///< whether exact_ is given what came with the frames
    std::unique_ptr<GeometryColour> geometry_;                 ///< for all of fills_; null: nothing to fill from
    std::map<std::string, std::unique_ptr<FrameFill>> fills_;  ///< by ladder, as far as any was used
    FrameFill* fill_ = nullptr;                                ///< the one in use
    bool missed_patch_depth_ = false;
    SourceDepths depths_;  ///< of the frame that was played last
    PictureCarrier carrier_;
    CarriedPicture carried_;  ///< of that frame, where it was carried on
};

}  // namespace equistream::play
