#pragma once
/// One client: a source, the clock that says which frame is due, and the pipeline that renders it for both eyes. One
/// thread at a time, but for now_s() and send_head(). client.h says what each setting means.
#include <equistream/client.h>

#include <client/pipeline/covering_view.h>
#include <client/pipeline/cpu_pipeline.h>
#include <client/pipeline/modules.h>
#include <client/playback/frame_loader.h>
#include <client/playback/playback.h>

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>

namespace equistream {

struct SessionSettings {
    std::string source, scene, engine, fill = default_fill;
    MirrorTreatment mirrors = MirrorTreatment::images;
    bool by_gl = false, confidence = false, paused = false, loop = false, hardware = true;
    double max_extrapolation_s = 0, exposure_stops = 0;
};

struct SessionEye {
    Pose in_head;
    FieldOfView fov;
};

struct SessionRequest {
    double display_s = 0;
    Pose head;
    std::array<SessionEye, 2> eyes;
    int width = 0, height = 0;
};

/// What is shown now.
struct SessionState : es_client_state {
    std::string problem;  ///< why that is not what was due; empty: it is
};

es_pose pose_of(const Pose& pose);

/// Of both eyes, in memory.
struct SessionPictures {
    std::array<PipelineEye, 2> eyes;
    CoveringView view;
};

class Session {
public:
    /// Where `gl` has a function for eyes they are rendered by OpenGL, else on the CPU. Throws InputError and
    /// WorkError.
    Session(const SessionSettings& settings, const RayModule& ray, const GlModule& gl);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    double now_s() const { return loader_->now_s(); }
    const ReceivedFrame& frame() const { return *shown_; }
    const FrameInfo& first() const { return loader_->first(); }
    bool is_live() const { return playback_->is_live(); }
    bool has_depth() const;
    const std::string& engine() const { return engine_; }

    /// Into memory. Both of these throw where nothing can be rendered, not even the frame before.
    SessionState render(const SessionRequest& request);
    /// Into the back end's textures.
    SessionState draw(const SessionRequest& request) { return render_due(request); }
    const SessionPictures& pictures() const { return pictures_; }  ///< of the last render
    const CoveringView& view() const { return view_; }             ///< of the last render or draw
    GlEyes* gl_eyes() { return gl_eyes_.get(); }                   ///< null: the CPU renders

    void pause() { playback_->pause(); }
    void play();
    void seek(double time_s);
    /// Any thread. Whether it was sent.
    bool send_head(const Pose& head);
    es_client_statistics statistics() const;

private:
    void check_stages(bool by_gl);
    void choose(const RayModule& ray, const GlModule& gl);
    PipelineWays ways() const;
    void show(SharedFrame frame);
    void count_shown();
    std::string advance(double display_s);
    bool begins_anew() const;
    SessionState shown_state() const;
    SessionState render_due(const SessionRequest& request);
    SessionState render_shown(const SessionRequest& request);
    double wanted_extrapolation_s() const;
    void choose_ways_of_frame();
    void render_cpu(const std::array<EyeView, 2>& eyes, SessionState& state);
    void render_gl(const std::array<EyeView, 2>& eyes, SessionState& state);
    std::array<EyeView, 2> set_views(const SessionRequest& request, SessionState& state);
    void download();
    void judge(es_client_statistics& all) const;

    SessionSettings settings_;
    std::optional<SceneDescription> scene_;
    std::string engine_;
    PoseSender poses_;
    std::unique_ptr<FrameLoader> loader_;
    std::unique_ptr<Playback> playback_;
    SharedFrame shown_;     ///< what is due
    SharedFrame rendered_;  ///< at the last call that rendered; the first frame before that
    std::atomic<double> shown_time_s_ = 0;
    CpuPipeline cpu_;
    bool by_depth_ = false;            ///< the CPU takes the source's depth
    bool lacks_depth_ = false;         ///< the shown frame's depth is missing
    std::unique_ptr<GlEyes> gl_eyes_;  ///< null: the CPU renders
    CoveringView view_;
    SessionPictures pictures_;
    es_client_statistics statistics_{};
    double decode_ms_ = 0, render_ms_ = 0;  ///< sums
    double display_s_ = 0;                  ///< the latest so far
    bool is_over_ = false, is_rendered_ = false;
};

}  // namespace equistream
