#pragma once
/// A refresh of the display, and what its time went into.
#include "frame_textures.h"

#include <equistream/elapsed.h>

#include <client/confidence/gl/reliability_map.h>
#include <client/depth/gl/depth_pass.h>
#include <client/depth/gl/sphere_depth.h>
#include <client/extrapolate/gl/motion_view.h>
#include <client/fill/gl/fill_pass.h>
#include <client/pipeline/left_windows.h>
#include <client/reflections/gl/specular.h>
#include <client/warp/gl/eye_depth_finder.h>
#include <client/warp/gl/eye_targets.h>
#include <client/warp/gl/resample.h>
#include <scenes/library/scene.h>

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace equistream::gl {

// What a refresh's time went into. GPUs work behind the caller's back: stages are told apart only where the pipeline
// is drained between them, which costs a little and is done while somebody looks at the figures.

enum class RenderStage { upload, depth, extrapolate, reproject, fill, judge, display };
inline constexpr std::array<std::string_view, 7> render_stage_names = {
    "upload", "depth", "extrapolate", "reproject", "fill", "reliability", "display"};

class StageTimes {
public:
    /// Of one refresh, in milliseconds.
    using Row = std::array<double, render_stage_names.size()>;

    void start(bool told_apart);
    /// What passed since the last mark was that stage's.
    void mark(RenderStage stage);

    const Row& row() const { return row_; }

private:
    bool told_apart_ = false;
    Clock::time_point last_;
    Row row_{};
};

// A refresh of the display: what both eyes see of the frame that came last, from wherever they are now. Depth by the
// scene's geometry (engine `eye-depth`) or by the frame's own or without (one that finds it), engine, mirrors, gaps
// and reliability, all on the GPU; shaders are compiled when it is made, those of a base's engine when the first base
// comes, storage there grows with what is asked for and is kept. The context it was made in is current in every call.

/// How a refresh is drawn.
struct RefreshOptions {
    bool surface = true;  ///< by depth where there is some, else by direction alone
    bool fill = true;
    bool reliability = false;
    bool motion = false;
    bool right_alone = false;  ///< of a single eye: it is the right one
    MirrorTreatment mirrors = MirrorTreatment::images;
};

class EyeRenderer {
public:
    /// Without a scene the eyes' depth is found from the frame's by `finding_engine`, and where it has none that the
    /// engine needs they only turn. `box_radius_m` sizes what depth may be off by. `fill`: a list of fill_stages().
    EyeRenderer(const SceneDescription* scene, double box_radius_m, const std::string& fill = default_fill,
                std::string_view finding_engine = default_finding_engine);
    ~EyeRenderer();

    /// From now on this frame is shown; the one before it stays for gaps.
    void show(std::shared_ptr<const ReceivedFrame> frame, StageTimes& times);

    /// What moves is from the next look() on shown so much later than in the frame, by its motion (extrapolate.h); from
    /// the next show() on as it comes.
    void extrapolate(double seconds) { extrapolation_s_ = seconds; }
    /// Whether that changes anything: the frame says what moves, and has depth, or the scene moves it too.
    bool can_extrapolate() const;
    /// By how much it is since the last look(); 0: it is shown as it came.
    double extrapolated_s() const { return is_extrapolated_ ? extrapolation_s_ : 0; }
    /// FrameTextures', of frames that are shown from now on.
    void read_in_place(const std::shared_ptr<PictureBuffers>& buffers);
    /// How HDR frames come to the display; before the first one. Null is no display.
    void show_pq_by(std::shared_ptr<PqDisplay> display);
    /// The same frames by another exposure; nothing where they are not HDR.
    void set_exposure(double stops);

    /// Where the eyes are now; all have one size. Only after a frame was shown.
    void look(std::span<const EyeView> eyes, bool by_depth, StageTimes& times);
    /// Draws what they see; by depth once after each look().
    void draw(const RefreshOptions& options, EyeTargets& targets, StageTimes& times);

    bool has_geometry() const { return geometry_ != nullptr; }
    /// Whether eyes that moved see more than the sphere turned.
    bool has_depth() const;
    const ReceivedFrame& frame() const { return *frames_[current_].frame(); }
    /// The same, kept.
    std::shared_ptr<const ReceivedFrame> shared_frame() const { return frames_[current_].shared_frame(); }
    const SourceTextures& source() const { return frames_[current_].main().textures; }
    /// What is known of the eyes'; texture 0: nothing.
    EyeDepth depth() const;
    GLuint reliability() const { return reliability_.texture(); }
    void download_reliability(int eye, EyePicture& picture) const { reliability_.download(eye, picture); }
    /// Of the last draw() since look() that was to find it, see MotionView; 0: there was none, or the frame says
    /// of nothing that it moves.
    GLuint motion() const { return has_motion_ ? motion_.texture() : 0; }

private:
    struct Geometry;
    /// The eyes' depth where they have none of their own.
    struct Finder {
        std::unique_ptr<EyeDepthFinder> engine;
        FoundDepth gaps;
        bool knows_extrapolated = false;  ///< what the engine knows is of a picture that was extrapolated
    };

    /// Null: the engine finds none.
    static std::unique_ptr<Finder> make_finder(std::string_view engine);
    /// Of a frame whose place another takes.
    void leave_window(std::size_t place);
    FrameTextures& current() { return frames_[current_]; }
    /// The frame shown before; null: there is none that gaps may be filled from.
    const FrameTextures* earlier() const;
    void find_depth();
    void find_depths_apart();
    bool needs_depth_beside();
    void find_depth_beside();
    bool frame_has_depth() const;
    /// By which the eyes' pixels are looked up, known or assumed; texture 0: by none.
    EyeDepth eyes_depth() const;
    /// Of frames with a picture for each eye: the one that this eye is made of.
    bool takes_right(std::size_t eye, bool right_alone) const;
    /// Each eye by its own picture, turned.
    void turn_apart(bool right_alone, EyeTargets& targets);
    /// Each eye by its own picture and that one's depth.
    void reproject_by_eye(EyeTargets& targets);
    void copy_eye(std::size_t eye, EyeTargets& targets);
    /// What is looked up by depth.
    const SourceTextures& resampled() const;
    /// What fill passes look up of the frame whose depth the scene's geometry gives.
    std::array<UploadedPicture*, 3> looked_up_beside();
    bool fills_from(TrackRole role) const;
    void find_left_windows();
    /// `by_surface`: the eyes looked the main picture up by depth.
    void fill(const EyeDepth& depth, bool by_surface, const EyeTargets& targets);
    GlFillFrame fill_frame(bool by_surface);
    /// What eyes see of the base alone, as they would of a main picture.
    SeenBase see_base(bool by_surface);
    /// The main picture of the frame that is shown, as it is looked up.
    SpecularSource mirroring();

    std::unique_ptr<Geometry> geometry_;
    std::unique_ptr<Finder> finder_;               ///< without geometry, where the engine finds depth
    std::string engine_;                           ///< the finder's
    std::unique_ptr<EyeDepthFinder> base_engine_;  ///< another of these, once a base has come
    std::shared_ptr<PqDisplay> pq_display_;
    std::array<FrameTextures, 2> frames_;
    std::size_t current_ = 0;
    std::vector<EyeView> eyes_;
    bool by_depth_ = false;  ///< whether theirs was found
    double extrapolation_s_ = 0;
    bool is_extrapolated_ = false, has_motion_ = false;
    PictureExtrapolator extrapolator_;
    MotionView motion_;
    Resample turn_, surface_;
    EyeTargets one_eye_;  ///< for turn_apart and reproject_by_eye
    /// Where a posed frame has a picture for each eye: the engine of the right one, without geometry; the depth of the
    /// eye at hand, and all eyes'.
    std::unique_ptr<EyeDepthFinder> right_engine_;
    Texture one_depth_, by_eye_depth_;
    Size by_eye_size_;
    int by_eye_count_ = 0;
    bool by_eye_ = false;                       ///< eyes were looked up so
    EyeTargets base_targets_;                   ///< for see_base
    std::array<SpecularTextures, 2> specular_;  ///< of frames_
    LeftWindows<LeftTextures> left_windows_;
    std::optional<LeftTextures> spare_;       ///< storage for the next one
    std::vector<LeftPicture> left_pictures_;  ///< those that the frame's gaps may be filled from
    Mirrors mirrors_;
    GapTiles gaps_;
    GapMirrors gap_mirrors_;
    GlFillShared fill_shared_;
    GlFillChain chain_;
    ReliabilityMap reliability_;
};

}  // namespace equistream::gl
