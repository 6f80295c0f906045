#pragma once
/// Which moment of the stream to show at which display time, so that a late, jittering or silent server is seen as
/// calmly as can be. Times are handed in, so that simulations and live players can run the same clock; one thread.
///
/// Frames arrive at offsets (arrival less frame time). The least of the last seconds is the path's own delay; the
/// play-out delay adds what on_time_share of the frames take beyond it, within bounds: the idea of the jitter buffers
/// of voice (Ramjee et al. 1994, "Adaptive playout mechanisms for packetized audio applications in wide-area
/// networks"), without their talk spurts: delay changes by playing a little faster or slower. Head motion does not wait
/// for any of this: poses are new at every refresh.
///
/// With room = newest frame + interval + usual lateness + overrun_s - shown, the rate is the least of
///     max_rate, what it was before + max_rate_rise_per_s per second         never a jolt forward
///     1 + behind / settle_s (at least min_rate)                             towards the play-out delay
///     room / overrun_s                                                     eased to a halt where nothing comes
/// all integrated exactly over a refresh, so that the refresh rate does not matter. What is shown while frames come in
/// time is therefore display time less a constant, at rate 1; when they stop, at a rate falling exponentially, at most
/// overrun_s beyond where the next frame would usually have come; when they come again, up to max_rate faster until it
/// is level, which passes over frames. Never backward.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace equistream {

struct MediaClockOptions {
    double start_delay_s = 0.1;     ///< play-out delay until start_frames have told of the jitter
    std::size_t start_frames = 16;  ///< at most media_clock_window
    double min_delay_s = 0.005;     ///< play-out delay: what decoding and uploading may vary by
    double max_delay_s = 0.25;      ///< frames that are later than that are no jitter but a stall
    double on_time_share = 0.5;     ///< of frames, that the play-out delay waits for
    double usual_share = 0.95;      ///< of frames: lateness up to that of this share does not slow the clock
    double window_s = 5;            ///< what is known of the path is that old at most
    double settle_s = 0.5;          ///< time constant of coming level
    double min_rate = 0.5;          ///< while frames come
    double max_rate = 4;
    double max_rate_rise_per_s = 6;
    double overrun_s = 0.2;    ///< beyond where the next frame usually comes, and the time constant of the halt
    double skip_behind_s = 5;  ///< further behind, nothing that is seen leads to what comes: a cut
    double pause_s = 1;        ///< without a refresh for so long, nobody looks: a cut as well
};

enum class ClockState {
    starting,     ///< nothing has come, or the first frame is held until play-out begins
    playing,      ///< frames come in time
    late,         ///< the next frame is overdue: what moves is extrapolated
    stalled,      ///< and has been for so long that nothing moves any more (rate below 0.05)
    catching_up,  ///< more than catch_up_s behind
    ended         ///< the last frame is shown
};
inline constexpr std::size_t clock_state_count = 6;
inline constexpr std::array<const char*, clock_state_count> clock_state_names = {"starting", "playing",     "late",
                                                                                 "stalled",  "catching_up", "ended"};

struct MediaTime {
    double frame_time_s = 0;  ///< what to show, on the server's clock
    double rate = 0;          ///< seconds of it per second of display
    ClockState state = ClockState::starting;
};

/// Frames that a clock remembers.
inline constexpr std::size_t media_clock_window = 128;

class MediaClock {
public:
    explicit MediaClock(const MediaClockOptions& options = {});

    /// A frame has come. In any order; not those that the ring refused.
    void arrived(double frame_time_s, double arrival_s);
    /// No more will.
    void end() { ended_ = true; }
    /// At a refresh; these ascend. Either when each is made or when it is seen: what lies between is delay as any
    /// other. Nothing before the first frame has come.
    std::optional<MediaTime> at(double display_s);

    /// How much later than the path's own delay frames are shown, once level.
    double playout_delay_s() const { return playout_delay_s_; }
    /// By how much frames arrive later than their times at least, of the last seconds: the path's delay, and what the
    /// two clocks are apart.
    double path_delay_s() const { return path_delay_s_; }
    /// Between frames, as they come: the median.
    double frame_interval_s() const { return interval_s_; }
    std::int64_t cuts() const { return cuts_; }

private:
    struct Sample {
        double offset_s, arrival_s, since_last_s;
    };

    void estimate();
    double aim_s(double display_s) const { return display_s - path_delay_s_ - playout_delay_s_; }
    double advance_s(double display_s, double elapsed_s);
    ClockState state(double display_s);

    MediaClockOptions options_;
    std::array<Sample, media_clock_window> samples_{};
    std::size_t sample_count_ = 0;  ///< ever
    double path_delay_s_ = 0, playout_delay_s_ = 0, usually_late_s_ = 0, interval_s_ = 1.0 / 30;
    double first_s_ = 0, newest_s_ = 0;  ///< frame times
    bool ended_ = false;

    bool moving_ = false;  ///< has shown more than the first frame
    bool catching_up_ = false;
    double shown_s_ = 0, display_s_ = 0, rate_ = 0;
    bool was_asked_ = false;
    std::int64_t cuts_ = 0;
};

}  // namespace equistream
