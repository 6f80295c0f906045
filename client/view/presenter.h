#pragma once
/// What a window shows of a source: frames as they come, seen from where the head will be when they are, refresh by
/// refresh, in the displaying thread. Nothing is drawn that would look the same.
#include "face/face.h"
#include "head_motion.h"
#include "input_box.h"
#include "input_router.h"
#include "meters.h"
#include "recorder.h"
#include "viewer_settings.h"
#include "watched_source.h"
#include "window.h"

#include <client/playback/playback.h>
#include <client/view/gl/display.h>
#include <client/view/gl/eye_renderer.h>
#include <client/view/gl/pixel_probe.h>
#include <client/view/xr/headset.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace equistream {

class Presenter {
public:
    /// Where it is shown: all outlives the presenter, and the window's context is current in every call. `headset` may
    /// be null.
    struct Place {
        InputBox& box;
        Window& window;
        Face& face;
        Headset* headset = nullptr;
    };

    /// Shows the first frame; throws what that throws.
    Presenter(WatchedSource& source, const ShownSettings& shown, const Place& place);
    ~Presenter();
    Presenter(const Presenter&) = delete;
    Presenter& operator=(const Presenter&) = delete;

    /// One refresh, and the rest until the next; at most `longest_rest_s` where nothing happens.
    void refresh(const ViewInputs& inputs, double longest_rest_s);
    /// Told by a key, or the headset.
    bool is_over() const { return quit_; }

    void act(Action action);
    void choose(const ShownSetting& setting, const std::string& value);
    void seek(double time_s);
    /// As before the source was opened anew: seen from the same place, as wide, at the same time; what is recorded goes
    /// on. Of a recorded source nothing is drawn until the frame of that time is there.
    void go_on_from(Presenter& before);
    /// A line at the bottom for a while.
    void tell(std::string message);
    const ShownSettings& shown() const { return shown_; }
    bool is_paused() const { return playback_.is_paused(); }
    /// Of others: the one that is being opened, empty: none is, and those that were.
    void know_of(const std::string& loading, const std::vector<std::string>& recent);
    ViewerReport report();

private:
    /// A place that is sought; back: an earlier frame than the one that is shown (Playback::seek_back).
    struct Jump {
        double time_s;
        bool goes_back;
    };

    /// Where it is, or is to be after the jumps that are under way.
    double wanted_s() const;
    void jump(const Jump& to);
    void jump_back(double by_s);
    void jump_on(double by_s);
    /// What is drawn again only if it changes.
    struct Drawn {
        Pose head;
        double extrapolation_s;
        bool is_awake;
        FaceContent content;
        bool operator==(const Drawn& other) const {
            return same_pose(head, other.head) && extrapolation_s == other.extrapolation_s &&
                   is_awake == other.is_awake && content == other.content;
        }
    };

    std::unique_ptr<gl::EyeRenderer> make_renderer(const ShownSettings& shown) const;
    void make_hdr_display();
    void show(SharedFrame frame);
    void press(const ShownSetting& setting);
    void change_to(const ShownSettings& wanted);
    void expose(double more_stops);
    bool refresh_window();
    void take_inputs();
    void refresh_headset();
    void draw_headset(const HeadsetView& seen);
    void mirror(GLuint framebuffer, const ViewPart& part);
    void show_mirror();
    void add_times();
    void rest(bool drew, double longest_s);
    void steer(double now_s);
    bool advance(double now_s);
    bool is_resuming();
    void lead();
    void record_head();
    double wanted_extrapolation_s(double until_seen_s) const;
    gl::RefreshOptions refresh_options() const;
    void end();
    void log_connection();
    void draw();
    void look(gl::Size window);
    bool shows_truth() const;
    bool shows_other() const;
    bool is_split() const;
    std::string why_no_truth() const;
    bool find_truth();
    void put_truth_beside();
    void draw_eyes(gl::Size window, bool splits);
    void render(std::span<const EyeView> eyes, bool splits);
    void render_or_turn(std::span<const EyeView> eyes, bool splits);
    bool draws_by_depth() const { return shown_.by_depth && depth_problem_.empty(); }
    const ReceivedFrame& frame() const { return renderer_->frame(); }
    Pose head() const;           ///< in the world, where it is now
    Pose foretold_head() const;  ///< in the world, where it is foretold to be
    double ipd_m() const;
    std::array<glm::dvec3, 2> eyes_m() const;  ///< in the world, left and right
    double beyond_head_box() const;            ///< fading, 0 to 1
    std::string lateness() const;
    std::string engine_in_use() const;
    std::string status() const;
    std::string warning() const;
    FaceContent make_content();
    std::vector<Fact> make_facts();
    void ask_for_pixel();
    void keep_what_is_asked_for();
    ByteImage read_back() const;
    double first_fov_deg() const;  ///< before anybody zoomed

    WatchedSource& source_;
    const ViewerSettings& settings_;
    ShownSettings shown_;
    Truth* truth_;                             ///< null: there is none
    std::shared_ptr<const TrueEye> true_eye_;  ///< of the frame that is shown, or null
    bool truth_is_coming_ = false;             ///< it is being read
    std::string truth_problem_;                ///< why it cannot be read; empty: it can
    double fov_deg_;
    FrameLoader& loader_;
    PoseSender& poses_;
    InputBox& box_;
    Window& window_;
    Face& face_;
    Headset* headset_;  ///< null: the window alone shows what there is
    ViewInputs inputs_;
    Playback playback_;
    // Of a recorded source: a place that is sought and not shown yet, and the latest one that was asked for meanwhile.
    // A mouse that is dragged would else keep every one of them from being shown.
    std::optional<double> seeking_s_;
    std::optional<Jump> next_jump_;
    bool resumes_ = false;                       ///< what it goes on from is not there yet, and nothing is drawn
    std::shared_ptr<gl::PqDisplay> pq_display_;  ///< of HDR frames; null: there are none
    std::unique_ptr<gl::EyeRenderer> renderer_;
    gl::Display display_;
    gl::EyeTargets targets_, other_targets_;
    std::string depth_problem_;  ///< why eyes cannot be drawn by depth, as far as was tried; empty: they can
    std::unique_ptr<Recorder> recorder_;
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
    std::string message_;  ///< what was written last
    double message_until_s_ = 0;
    std::optional<double> truth_db_;  ///< of what was drawn last
    EyePicture seen_;                 ///< memory for that
    std::int64_t truth_count_ = 0;
    ViewerReport report_;

    // What the face says.
    FaceContent content_;
    Meter refreshes_, frames_, bits_;
    std::int64_t counted_bytes_ = 0;
    double measured_s_ = -1;   ///< when facts were made last; negative: not yet
    std::vector<Fact> facts_;  ///< as they were then
    gl::PixelProbe probe_;
    std::optional<std::array<EyeView, gl::max_eyes>> eyes_;  ///< that were drawn last
    std::vector<Fact> mouse_facts_;
    double asked_s_ = -1;               ///< when the probe was asked last
    std::optional<EyeView> asked_eye_;  ///< and of which eye, as it was then
};

}  // namespace equistream
