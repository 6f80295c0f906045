#include "player.h"

#include "frame_player.h"
#include "head_steering.h"
#include "outputs.h"

#include <client/stages/stages.h>
#include <client/timing/viewing.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <programs/cli/process.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <optional>
#include <utility>

namespace equistream::play {

namespace {

/// The way that uses most of all that there may be, as far as the settings tell before the source is opened.
Plan widest_plan(const Settings& settings) {
    const bool by_budget = settings.method == "auto";
    const bool casts = is_cast(settings.depth) || (settings.depth.empty() && !settings.scene.empty());
    return {.method = settings.method.empty() || by_budget ? "eye-depth" : settings.method,
            .depth = casts && !by_budget ? "ray" : "stream",
            .fill = settings.fill,
            .mirrors = settings.asks_for_mirrors()};
}

/// A frame and the bytes that came with it.
struct Incoming {
    ReceivedFrame frame;
    std::int64_t bytes = 0;
};

/// A frame that is shown again was not decoded again.
void forget_decoding(ReceivedFrame& frame) {
    frame.main.decode_ms = frame.main.convert_ms = 0;
    for (auto* other : {&frame.base, &frame.small, &frame.hidden, &frame.patches})
        if (*other)
            (*other)->decode_ms = (*other)->convert_ms = 0;
}

class Run {
public:
    explicit Run(const Settings& settings) : progress_("play", 1, settings.progress) {
        report_.settings = settings;
        left_out_ = unneeded_roles(widest_plan(settings).choice()).to_ulong();
        feed_ = open_feed(settings.source, {.depth = true,
                                            .yuv = true,
                                            .hdr_display = settings.hdr_display,
                                            .specular = true,
                                            .left_out = [this] { return TrackRoles(left_out_.load()); },
                                            .first_frame = settings.frames.first,
                                            .last_frame = settings.frames.last,
                                            .frames_ahead = 1,
                                            .interrupted = [] { return cli::interrupted().load(); },
                                            .poses = settings.head.empty() ? nullptr : &poses_});
        player_ = std::make_unique<FramePlayer>(settings);
        if (!settings.head.empty())
            steering_.emplace([this](double time_s) { return player_->head_at(time_s); },
                              [this](const ViewerPose& pose) { return poses_.send(pose); });
        first_ = read();
        if (!first_)
            throw InputError(expected_found(
                settings.source,
                settings.frames.last < Settings{}.frames.last ? "frames in the range asked for" : "frames",
                feed_->truncation().empty() ? "none" : feed_->truncation()));
        poses_.look_through(player_->eye_camera(first_->frame.main.info));
        player_->prepare(first_->frame, report_);
        if (settings.method == "auto")
            read_second();
        player_->settle(first_->frame, second_ ? &second_->frame : nullptr, report_);
        left_out_ = unneeded_roles({.engine = report_.method,
                                    .depth = report_.depth,
                                    .fill = report_.fill,
                                    .mirrors = settings.asks_for_mirrors()})
                        .to_ulong();
        if (first_->frame.posed)
            report_.source = first_->frame.main.info;
        outputs_ = std::make_unique<Outputs>(settings);
    }

    void all_pictures() {
        cli::note_interrupts();
        if (report_.settings.refresh_hz)
            all_refreshes();
        else
            all_frames();
    }

    void end() {
        outputs_->finish();
        report_.truncation = feed_->truncation();
        note_head_box();
        note_missing();
        note_lost_depth();
        note_hdr();
        note_patches();
        note_window();
        write_report();
    }

    /// After a failure: what was made is kept and reported as far as that still works.
    void keep_what_there_is() noexcept {
        try {
            if (!has_failed_to_write_)  // videos may lack frames: they keep the name NAME.part
                outputs_->finish();
        } catch (const std::exception&) {
            // The failure that brought us here is the one to tell of.
        }
        try {
            write_report();
        } catch (const std::exception&) {
            // As above: a full disk fails here again.
        }
    }

    Report take_report() { return std::move(report_); }

private:
    std::optional<Incoming> read() {
        std::optional<ReceivedFrame> frame = feed_->next();
        stop_if_interrupted();
        if (!frame)
            return std::nullopt;
        if (steering_ && frame->posed)
            steering_->came(frame->main.info);
        std::int64_t bytes = 0;
        for (const FeedTrack& track : feed_->tracks())
            bytes += track.bytes;
        if (frame->posed || feed_->is_live())  // other videos' frames are numbered by their times
            count_missing(frame->main.info.index);
        return Incoming{std::move(*frame), bytes - std::exchange(read_bytes_, bytes)};
    }

    void stop_if_interrupted() {
        if (!cli::interrupted())
            return;
        report_.truncation = "interrupted: " + all_played() + " played and kept";
        throw WorkError(report_.truncation + "; to start over, add --overwrite to the same command");
    }

    std::string all_played() const {
        return std::to_string(report_.played) + (report_.settings.refresh_hz ? " refreshes" : " frames");
    }

    void count_missing(std::int64_t index) {
        if (last_ && index > *last_ + 1) {
            missing_ += index - *last_ - 1;
            first_missing_ = first_missing_.value_or(*last_ + 1);
        }
        last_ = index;
    }

    /// Where it cannot be read, the first is played before that is told.
    void read_second() {
        try {
            second_ = read();
        } catch (...) {
            second_problem_ = std::current_exception();
        }
    }

    /// The next one to be played.
    std::optional<Incoming> next() {
        for (std::optional<Incoming>* waiting : {&first_, &second_})
            if (*waiting)
                return std::exchange(*waiting, std::nullopt);
        if (second_problem_)
            std::rethrow_exception(std::exchange(second_problem_, nullptr));
        return read();
    }

    void all_frames() {
        PlayedFrame played;
        while (std::optional<Incoming> incoming = next()) {
            const std::int64_t index = incoming->frame.main.info.index;
            player_->rechoose(played, index, report_);
            player_->play(incoming->frame, played);
            write(played);
            progress_.step(feed_->fraction_done().value_or(0), "frame " + std::to_string(index));
            player_->remember(std::move(incoming->frame));
        }
    }

    void all_refreshes() {
        report_.viewing.emplace();
        viewing_ = std::make_unique<ViewingSimulation>(
            report_.settings.conditions,
            ViewingOptions{.refresh_hz = *report_.settings.refresh_hz,
                           .extrapolation_limit_s = report_.settings.extrapolation_limit_s},
            [this](double time_s) { return player_->head_at(time_s); });
        PlayedFrame played;
        std::shared_ptr<ReceivedFrame> shown;
        for (;;) {
            stop_if_interrupted();  // through a stall nothing is read
            while (viewing_->needs_frame())
                send_next();
            const std::optional<ViewedRefresh> refresh = viewing_->next();
            if (!refresh)
                break;
            report_.viewing->refreshes.push_back(*refresh);
            if (!refresh->frame)
                continue;
            if (shown == viewing_->shown()) {
                forget_decoding(*shown);
            } else {
                if (shown)
                    player_->remember(std::move(*shown));
                shown = viewing_->shown();
            }
            player_->rechoose(played, refresh->number, report_);
            const double extrapolation_s = report_.settings.extrapolation_limit_s > 0 ? refresh->extrapolation_s() : 0;
            const RefreshMoment moment{refresh->number, refresh->display_s, *report_.settings.refresh_hz,
                                       refresh->predicted_head, extrapolation_s};
            player_->play(*shown, played, &moment);
            write(played);
            progress_.step(feed_->fraction_done().value_or(0), "refresh " + std::to_string(refresh->number));
        }
    }

    void send_next() {
        std::optional<Incoming> incoming = next();
        if (!incoming) {
            viewing_->end();
            return;
        }
        const FrameInfo& info = incoming->frame.main.info;
        // A server that renders for this viewer has the head of that time.
        const ServedFrame served{info.index, info.time_s, player_->head_at(info.time_s), incoming->bytes};
        viewing_->send(served, std::make_shared<ReceivedFrame>(std::move(incoming->frame)));
    }

    void write(PlayedFrame& played) {
        const auto start = Clock::now();
        has_failed_to_write_ = true;  // unless it returns
        outputs_->write(played);
        has_failed_to_write_ = false;
        played.figures.milliseconds[std::size_t(Stage::write)] = {milliseconds_since(start)};
        report_.add(std::move(played.figures));
    }

    void note_head_box() {
        if (report_.outside_head_box > 0)
            report_.notes.push_back("in " + std::to_string(report_.outside_head_box) + " of " + all_played() +
                                    " an eye is outside the head box that " + report_.settings.source +
                                    " was rendered for: parallax there is beyond its error bound");
    }

    void note_missing() {
        if (missing_ > 0)
            report_.notes.push_back(report_.settings.source + ": frames missing in between: " +
                                    std::to_string(missing_) + ", the first is " + std::to_string(*first_missing_));
    }

    void note_lost_depth() {
        if (report_.lacking_depth > 0)
            report_.notes.push_back("in " + std::to_string(report_.lacking_depth) + " of " + all_played() +
                                    " the depth of " + report_.settings.source +
                                    " is missing: method rotation there (the eye only turns)");
    }

    void note_hdr() {
        if (report_.settings.format == Format::exr && std::ranges::count(feed_->transfers(), "smpte2084") > 0)
            report_.notes.push_back("EXR views are clipped at white, and " + report_.settings.source +
                                    " is HDR: --format png with --view-transform shows its highlights");
    }

    void note_patches() {
        if (player_->missed_patch_depth())
            report_.notes.push_back("--fill patches is ignored: " + report_.settings.source +
                                    " has patches without depth, and --depth " + report_.depth +
                                    " does not draw it (--depth ray casts it)");
    }

    /// Whoever names passes leaves the window out by leaving out the one that shows what lies around it.
    void note_window() {
        const bool is_unneeded = unneeded_roles(widest_plan(report_.settings).choice())[std::size_t(TrackRole::window)];
        const auto is_window = [](const FeedTrack& track) { return track.name == track_name(TrackRole::window); };
        if (is_unneeded && std::ranges::any_of(feed_->tracks(), is_window))
            report_.notes.push_back("the window of " + report_.settings.source +
                                    " is ignored: --fill lacks base, the sphere around it");
    }

    /// Others were left out once the way was chosen: in time for which frame differs from run to run.
    std::vector<FeedTrack> used_tracks() const {
        std::vector<FeedTrack> tracks = feed_->tracks();
        const TrackRoles left_out(left_out_.load());
        for (int role = 0; role < track_role_count; ++role)
            if (left_out[std::size_t(role)])
                std::erase_if(tracks,
                              [&](const FeedTrack& track) { return track.name == track_name(TrackRole(role)); });
        return tracks;
    }

    void write_report() {
        report_.tracks = used_tracks();
        if (steering_ && steering_->figures().heads_sent > 0)
            report_.steering = steering_->figures();
        report_.output_bytes = outputs_->bytes();
        if (report_.viewing) {
            report_.viewing->report = report_viewing(report_.viewing->refreshes, *report_.settings.refresh_hz);
            viewing_->add_figures(report_.viewing->report);
        }
        outputs_->write_report(report_);
    }

    Report report_;
    cli::Progress progress_;
    std::atomic<unsigned long> left_out_ = 0;  ///< TrackRoles, as the feed's thread asks for them
    PoseSender poses_;
    std::unique_ptr<FrameFeed> feed_;
    std::optional<HeadSteering> steering_;  ///< where there is a head's path
    std::unique_ptr<FramePlayer> player_;
    std::unique_ptr<Outputs> outputs_;
    bool has_failed_to_write_ = false;
    std::int64_t read_bytes_ = 0;
    std::optional<std::int64_t> last_, first_missing_;  // frames' numbers
    std::int64_t missing_ = 0;                          // frames between others
    std::optional<Incoming> first_, second_;            ///< as far as they were read before the first is played
    std::exception_ptr second_problem_;                 ///< what kept the second from being read
    std::unique_ptr<ViewingSimulation> viewing_;        ///< where there are refreshes
};

}  // namespace

Report play(const Settings& settings) {
    Run run(settings);
    try {
        run.all_pictures();
        run.end();
    } catch (const InputError& e) {
        run.keep_what_there_is();
        throw WorkError(e.what());
    } catch (...) {
        run.keep_what_there_is();
        throw;
    }
    return run.take_report();
}

}  // namespace equistream::play
