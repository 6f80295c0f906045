#pragma once
/// What a viewer is asked for, and what its window shows.
#include "head_motion.h"
#include "input_box.h"
#include "panels.h"
#include "recorder.h"
#include "truth.h"
#include "window.h"

#include <equistream/colour.h>
#include <equistream/object_motion.h>

#include <client/fill/fill.h>
#include <client/playback/frame_loader.h>
#include <client/playback/playback.h>
#include <client/reflections/specular.h>
#include <client/view/gl/display.h>
#include <client/view/gl/eye_renderer.h>
#include <client/view/xr/headset.h>
#include <client/warp/engine.h>
#include <client/warp/gl/eye_depth_finder.h>
#include <scenes/library/scene.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

// What a viewer is asked for, and what it says of itself in the end.

inline constexpr gl::Size default_window_size{1280, 720};
inline constexpr double default_view_fov_deg = 90;

/// How a decoder's pictures come to the GPU. mapped: it reads them where the decoder wrote them, in its driver's own
/// buffers, where the driver has such; copied: they are copied. by_driver: mapped, unless the driver draws on the CPU.
enum class PictureUpload { by_driver, mapped, copied };

struct ViewerSettings {
    std::string source;                     ///< file, URL or folder
    std::optional<SceneDescription> scene;  ///< whose geometry gives depth
    /// Nothing: the truth's, else as the defaults are.
    std::optional<gl::Size> size;
    std::optional<double> fov_deg;
    std::optional<double> ipd_m;                             ///< nothing: what the frames are tagged with
    std::string finding_engine{gl::default_finding_engine};  ///< by which depth is found without a scene
    bool by_depth = true, fill = true, loop = true, paused = false, times = false;
    std::string fill_chain = default_fill;  ///< that gaps are filled by, where they are
    MirrorTreatment mirrors = MirrorTreatment::images;
    /// How HDR comes to the display; null: HdrDisplay's defaults. Where one is given the source must be HDR.
    std::shared_ptr<const HdrDisplay> hdr_display;
    bool headset = false;  ///< shown in one by OpenXR, the window beside it
    bool hardware = true;  ///< decode by it where there is some
    PictureUpload upload = PictureUpload::by_driver;
    gl::DisplayLayout layout = gl::DisplayLayout::left;
    gl::Overlay overlay = gl::Overlay::none;
    const Anaglyph* anaglyph = &anaglyphs().front();
    std::optional<double> predict_s;  ///< how far ahead the head is foretold; nothing: as far as is measured
    double extrapolation_limit_s =
        extrapolation_horizon_s;      ///< see Playback::extrapolation_s; 0: what moves stays where frames show it
    std::filesystem::path truth;      ///< folder of path-traced eyes of the same path; empty: there is none
    std::filesystem::path out = ".";  ///< of pictures and recordings
    double seconds = 0;               ///< after which it ends by itself; 0: when it is told to
};

struct ViewerReport {
    double seconds = 0;
    std::int64_t refreshes = 0;  ///< that were drawn: a still picture is drawn once
    std::int64_t frames = 0;     ///< that were shown
    double extrapolation_s = 0;  ///< by which what moves was shown later than in its frame, on average over refreshes
    std::optional<double> truth_db;  ///< PSNR of what was seen beside the truth, on average over refreshes
    double latency_s = 0;            ///< from the last look at what steers until the buffers were swapped, on average
    std::optional<double> playout_delay_s;  ///< of a live source, in the end
    std::string decoder;                    ///< of the last frame; empty: it was not coded
    double decode_ms = 0;                   ///< ReceivedPicture's, on average over frames
    std::size_t mapped_bytes = 0;           ///< of buffers that decoders wrote into, in the end
    /// Of all refreshes, in milliseconds; nothing unless stages were told apart.
    std::optional<gl::StageTimes::Row> stages_ms;
};

// What the window shows: frames as they come, seen from where the head will be when they are, refresh by refresh, in
// the displaying thread. Nothing is drawn that would look the same.

class Presenter {
public:
    /// In the window's context, which is current wherever this is called; all else outlives it. `truth` may be null.
    Presenter(const ViewerSettings& settings, Truth* truth, FrameLoader& loader, PoseSender& poses, InputBox& box,
              Window& window);
    ~Presenter();
    Presenter(const Presenter&) = delete;
    Presenter& operator=(const Presenter&) = delete;

    /// EyeRenderer's.
    void read_in_place(const std::shared_ptr<gl::PictureBuffers>& buffers) { renderer_.read_in_place(buffers); }
    /// Until the window is closed, or it was told to end.
    void run();
    ViewerReport report() const;

private:
    /// What is drawn again only if it changes.
    struct Drawn {
        Pose head;
        double extrapolation_s;
        StatusLine status;
        bool operator==(const Drawn& other) const {
            return same_pose(head, other.head) && extrapolation_s == other.extrapolation_s && status == other.status;
        }
    };

    void make_hdr_display();
    void show(SharedFrame frame);
    void expose(double more_stops);
    bool refresh_window();
    void take_inputs();
    void refresh_headset();
    void draw_headset(const HeadsetView& seen);
    void mirror(GLuint framebuffer, const ViewPart& part);
    void show_mirror();
    void add_times();
    void rest(bool drew);
    void steer(double now_s);
    bool advance(double now_s);
    void lead();
    double wanted_extrapolation_s(double until_seen_s) const;
    gl::RefreshOptions refresh_options() const;
    void end();
    void log_connection();
    void draw(const StatusLine& status);
    void look(gl::Size window);
    bool shows_truth() const;
    std::string why_no_truth() const;
    bool find_truth();
    void put_truth_beside();
    void draw_eyes(gl::Size window, bool splits);
    void act(Action action);
    void seek(double time_s);
    const ReceivedFrame& frame() const { return renderer_.frame(); }
    Pose head() const;           ///< in the world, where it is now
    Pose foretold_head() const;  ///< in the world, where it is foretold to be
    double ipd_m() const;
    std::array<glm::dvec3, 2> eyes_m() const;  ///< in the world, left and right
    double beyond_head_box() const;            ///< fading, 0 to 1
    std::string lateness() const;
    StatusLine status() const;
    void tell(std::string message);
    void keep_what_is_asked_for();
    ByteImage read_back() const;
    bool is_over() const;
    double first_fov_deg() const;  ///< before anybody zoomed

    ViewerSettings settings_;
    Truth* truth_;
    std::shared_ptr<const TrueEye> true_eye_;  ///< of the frame that is shown, or null
    bool truth_is_coming_ = false;             ///< it is being read
    std::string truth_problem_;                ///< why it cannot be read; empty: it can
    double fov_deg_;
    FrameLoader& loader_;
    PoseSender& poses_;
    InputBox& box_;
    Window& window_;
    TakenInputs inputs_;
    Playback playback_;
    std::unique_ptr<Headset> headset_;  ///< null: the window alone shows what there is
    gl::EyeRenderer renderer_;
    gl::Display display_;
    Panels panels_;
    gl::EyeTargets targets_, other_targets_;
    Recorder recorder_;
    gl::StageTimes times_;
    Steering steering_;  ///< as it was told last
    HeadMotion motion_;
    FollowedHead followed_;
    DisplayLatency latency_;
    Pose seen_head_;                           ///< in the axes of what it is moved around, foretold
    double extrapolation_s_ = 0;               ///< by which what moves is shown later than in the frame
    bool is_worn_ = false;                     ///< the headset shows this frame to somebody, and seen_head_ is theirs
    std::array<glm::dvec3, 2> worn_eyes_m_{};  ///< in the world, where it is worn
    std::optional<Drawn> drawn_;               ///< into the window last; nothing: what the headset shows
    double began_s_, now_s_, drawn_s_ = 0;     ///< on the loader's clock
    bool was_lost_ = false;
    float split_ = 1;
    bool quit_ = false, picture_wanted_ = false;
    std::optional<double> exposure_stops_;  ///< of HDR frames; nothing: there are none
    std::string message_;                   ///< what was written last
    double message_until_s_ = 0;
    std::optional<double> truth_db_;  ///< of what was drawn last
    EyePicture seen_;                 ///< memory for that
    std::int64_t truth_count_ = 0;
    ViewerReport report_;
};

}  // namespace equistream
