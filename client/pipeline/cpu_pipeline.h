#pragma once
/// The pipeline's CPU back end: one frame at a time, from what was received to both eyes' finished pictures.
#include "decisions.h"
#include "depth_maker.h"
#include "eye_steps.h"

#include <client/extrapolate/extrapolate.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// One eye: where it looks from, and what it sees then.
struct PipelineEye {
    PerspectiveCamera camera;
    Pose pose;
    EyePicture picture;
    ByteImage gaps;      ///< where PipelineWays asks for it: 255 where the engine left a gap, else 0
    FloatImage depth_m;  ///< empty where nothing needed it
    EyeFigures figures;
    bool takes_right = false;  ///< it is made of the frame's right picture

    /// Of local geometry, or what the engine found itself; empty where there is neither.
    ImageView<const float> depth_view() const {
        const FloatImage& plane = depth_m.empty() ? picture.depth_m : depth_m;
        return plane.empty() ? ImageView<const float>{} : plane.view();
    }
    EyeView view() const { return {camera, pose, depth_m.empty() ? ImageView<const float>{} : depth_m.view()}; }
};

/// Milliseconds of one frame, both eyes.
struct PipelineTimes {
    double depth = 0;       ///< all of it, with what moving objects take
    double fill_depth = 0;  ///< of `depth`, what pictures for gaps took
    double reproject = 0, fill = 0, reliability = 0;
};

/// How frames are shown; may change from frame to frame.
struct PipelineWays {
    std::string engine;
    EngineOptions engine_options{};
    bool by_depth = true;   ///< false: the depth source is not asked
    bool by_planes = true;  ///< depth that came with the frames is used, where the depth source hands it out
    std::string fill = default_fill;
    MirrorTreatment mirrors = MirrorTreatment::images;
    bool reliability = false, gap_masks = false;
};

/// One thread at a time; it uses all cores itself.
class CpuPipeline {
public:
    CpuPipeline();
    ~CpuPipeline();

    void use(const PipelineWays& ways);
    void use(MadeDepth depth);
    /// Also hands out depth that comes with the frames, before what it casts.
    void offer_planes();
    /// For the pass `geometry`, whatever the chain; null: it fills nothing.
    void use(std::unique_ptr<GeometryColour> geometry);
    bool has_geometry_colour() const { return geometry_ != nullptr; }
    bool hands_out_planes() const { return depth_.planes != nullptr; }
    const FrameFill& fill() const { return *fill_; }
    const Engine& engine() const { return steps_->engine(); }

    /// By how much later than in the frame moving objects are shown where `wanted_s` is asked for: 0 where nothing
    /// moves, or where no depth says what they pass in front of. `has_scene`: depth of any time and view can be cast.
    double extrapolation_s(const ReceivedFrame& frame, const PipelineEye& left, const PipelineEye& right,
                           double wanted_s, bool has_scene) const;
    /// Fills both eyes' pictures, which keep their memory from the frame before. Throws WorkError where a picture has
    /// another size than it is tagged with, and where depth did not come that nothing else gives.
    void render(const ReceivedFrame& frame, PipelineEye& left, PipelineEye& right, double extrapolation_s,
                PipelineTimes& times);
    /// Depth alone, as render would find it: what remember() keeps with a frame.
    void find_depths(const ReceivedFrame& frame, PipelineEye& left, PipelineEye& right);
    /// Main picture of the frame that was rendered last, for the pass `earlier`, and the base around it or null.
    void remember(std::shared_ptr<const ReceivedPicture> main, std::shared_ptr<const ReceivedPicture> base);
    /// As if no frame had come before.
    void forget();
    /// Keeps the frames that another chain's pass `earlier` had.
    void take_over(const std::string& fill_before);

    /// Of the last render, where moving objects were shown later.
    std::int64_t moved_pixels() const { return extrapolated_.moved_pixels; }
    std::int64_t uncovered_pixels() const { return extrapolated_.uncovered_pixels; }
    /// Whether patches came whose depth neither the stream had nor the depth source gives.
    bool missed_patch_depth() const { return missed_patch_depth_; }

private:
    bool takes_depth() const { return depth_.source != nullptr && ways_.by_depth; }
    bool takes_planes() const { return depth_.planes != nullptr && ways_.by_planes; }
    static void choose_pictures(const ReceivedFrame& frame, PipelineEye& left, PipelineEye& right);
    void set_frame_time(const ReceivedFrame& frame);
    void offer(const ReceivedFrame& frame);
    void cast(const Camera& camera, const Pose& pose, FloatImage& depth_m);
    void cast_depths(const ReceivedFrame& frame, PipelineEye& left, PipelineEye& right, double extrapolation_s,
                     PipelineTimes& times);
    void cast_fill_depths(const ReceivedFrame& frame, SourceDepths& memory);
    void cast_patches(const ReceivedPicture& patches, FloatImage& depth_m);
    void reproject(const ReceivedFrame& frame, const SourceView& source, PipelineEye& left, PipelineEye& right);
    const EyeSteps& steps_of(const PipelineEye& eye) const { return eye.takes_right ? *right_steps_ : *steps_; }
    void fill_gaps_of(const ReceivedFrame& frame, const SourceView& source, PipelineEye& left, PipelineEye& right,
                      double shown_s);
    void judge(const ReceivedFrame& frame, PipelineEye& left, PipelineEye& right);

    PipelineWays ways_;
    MadeDepth depth_;
    std::unique_ptr<EyeSteps> steps_, right_steps_;
    std::unique_ptr<BaseEngine> base_engine_;
    std::unique_ptr<GeometryColour> geometry_;                 ///< for all of fills_
    std::map<std::string, std::unique_ptr<FrameFill>> fills_;  ///< by chain, as far as any was used
    FrameFill* fill_ = nullptr;                                ///< the one in use
    SourceDepths depths_;                                      ///< of the frame that was rendered last
    PictureExtrapolator extrapolator_;
    ExtrapolatedPicture extrapolated_;
    bool missed_patch_depth_ = false;
};

/// 255 where nobody has given the pixel a colour, else 0; `mask` keeps its memory where it has the picture's size.
void find_gap_mask(const EyePicture& picture, ByteImage& mask);

}  // namespace equistream
