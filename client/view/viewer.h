#pragma once
/// The viewer: frames as they come, the head as it is steered, and what the window shows of both, refresh by refresh.
#include "followed_head.h"
#include "frame_loader.h"
#include "gl/display.h"
#include "gl/eye_renderer.h"
#include "keys.h"
#include "navigator.h"
#include "panels.h"
#include "recorder.h"
#include "window.h"

#include <equistream_scene/scene.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace equistream {

struct ViewerSettings {
    std::string source;                     ///< file, URL or folder
    std::optional<SceneDescription> scene;  ///< whose geometry gives depth
    gl::Size size{1280, 720};
    double fov_deg = 90;
    std::optional<double> ipd_m;  ///< nothing: what the frames are tagged with
    bool surface = true, fill = true, loop = true, paused = false, times = false, help = false;
    gl::DisplayLayout layout = gl::DisplayLayout::left;
    gl::Overlay overlay = gl::Overlay::none;
    const Anaglyph* anaglyph = &anaglyphs().front();
    std::filesystem::path out = ".";  ///< of pictures and recordings
    double seconds = 0;               ///< after which it ends by itself; 0: when it is told to
};

class Viewer {
public:
    /// Opens the source first and then a window. Throws InputError for either.
    explicit Viewer(const ViewerSettings& settings);
    ~Viewer();

    /// Until the window is closed.
    void run();
    /// One refresh, so long after the last. False: it is over.
    bool refresh(double since_last_s);
    void act(Action action);

private:
    void steer(const Inputs& inputs, double seconds);
    void lead();
    bool is_served() const { return settings_.source.find("://") != std::string::npos; }
    void advance(double seconds);
    void step();
    void play(double seconds);
    void end();
    void show(SharedFrame frame);
    void seek(double time_s);
    void look(gl::Size window);
    void draw_eyes(gl::Size window, bool splits);
    const ReceivedFrame& frame() const { return renderer_->frame(); }
    Pose head() const;
    double beyond_head_box() const;  ///< fading, 0 to 1
    StatusLine status() const;
    void tell(std::string message);
    void keep_what_is_asked_for();
    ByteImage read_back() const;

    ViewerSettings settings_;
    PoseSender poses_;
    FrameLoader loader_;
    std::unique_ptr<Window> window_;
    std::unique_ptr<gl::EyeRenderer> renderer_;
    std::optional<gl::Display> display_;
    std::optional<Panels> panels_;
    gl::EyeTargets targets_, other_targets_;
    Recorder recorder_;
    gl::StageTimes times_;
    Navigator navigator_;
    FollowedHead followed_;
    double time_s_ = 0;      ///< of the source
    double run_s_ = 0;       ///< since the viewer began
    bool stepping_ = false;  ///< the next frame is shown whenever it comes
    float split_ = 1;
    bool quit_ = false, picture_wanted_ = false;
    std::string message_;  ///< what was written last
    double message_until_s_ = 0;
};

}  // namespace equistream
