#include "presenter.h"

#include <equistream/text.h>

#include <algorithm>
#include <functional>
#include <map>

namespace equistream {

namespace {

constexpr double message_s = 4, second_s = 1;
constexpr float split_step = 0.05f;
constexpr double exposure_step_stops = 0.25;
/// What is less late shows itself by nothing but pictures that come late.
constexpr double longest_unsaid_s = 0.5;

}  // namespace

void Presenter::tell(std::string message) {
    message_ = std::move(message);
    message_until_s_ = now_s_ + message_s;
}

double Presenter::wanted_s() const {
    return next_jump_ ? next_jump_->time_s : seeking_s_.value_or(frame().main.info.time_s);
}

void Presenter::seek(double time_s) {
    jump({time_s, false});
}

void Presenter::jump(const Jump& to) {
    if (playback_.is_live())
        return tell("a live stream cannot seek");
    if (!playback_.can_jump())
        return tell("a pipe cannot seek: it is read once");
    if (seeking_s_) {
        next_jump_ = to;
        return;
    }
    seeking_s_ = to.time_s;
    if (to.goes_back)
        playback_.seek_back(to.time_s);
    else
        playback_.seek(to.time_s);
}

void Presenter::jump_back(double by_s) {
    jump({wanted_s() - by_s, true});
}

/// At the last frame there is nothing to jump to.
void Presenter::jump_on(double by_s) {
    const double at_s = wanted_s(), to_s = playback_.time_on_s(at_s, by_s, source_.seconds());
    if (to_s > at_s)
        seek(to_s);
}

void Presenter::choose(const ShownSetting& setting, const std::string& value) {
    ShownSettings wanted = shown_;
    for (const std::string& note : setting.set(wanted, value))
        tell(note);
    change_to(wanted);
}

/// What shows itself in the picture is not said besides.
void Presenter::press(const ShownSetting& setting) {
    choose(setting, setting.next(shown_));
    if (setting.menu != SettingMenu::view)
        tell(std::string(setting.label) + ": " + setting.value(shown_));
}

/// What is made anew for it is there before anything changes.
void Presenter::change_to(const ShownSettings& wanted) {
    const bool has_scene = settings_.scene.has_value();
    if (wanted.engine != shown_.engine || wanted.fill_chain != shown_.fill_chain ||
        (has_scene && wanted.by_geometry != shown_.by_geometry)) {
        auto renderer = make_renderer(wanted);
        if (pq_display_)
            renderer->show_pq_by(pq_display_);
        renderer->show(renderer_->shared_frame(), times_);
        renderer_ = std::move(renderer);
    }
    if (wanted.by_depth != shown_.by_depth || wanted.by_geometry != shown_.by_geometry ||
        wanted.engine != shown_.engine)
        depth_problem_.clear();
    if (pq_display_ && wanted.exposure_stops != shown_.exposure_stops)
        renderer_->set_exposure(wanted.exposure_stops);
    shown_ = wanted;
    measured_s_ = -1;
    drawn_.reset();
}

void Presenter::expose(double more_stops) {
    if (!pq_display_) {
        tell("exposure: for HDR streams only");
        return;
    }
    ShownSettings wanted = shown_;
    wanted.exposure_stops = std::clamp(shown_.exposure_stops + more_stops, -max_exposure_stops, max_exposure_stops);
    change_to(wanted);
    tell(formatted("exposure %+.2f stops", shown_.exposure_stops));
}

void Presenter::act(Action action) {
    const FrameInfo& info = frame().main.info;
    const double interval_s = 1 / info.frames_per_second;
    const double jump_s = std::max(second_s, interval_s);  // never to the same frame
    // Those that are held are steer's.
    const std::map<Action, std::function<void()>> once = {
        {Action::centre,
         [&] {
             motion_.centre();
             fov_deg_ = first_fov_deg();
             if (headset_)
                 headset_->recentre();
         }},
        {Action::play_pause, [&] { playback_.is_paused() ? playback_.play() : playback_.pause(); }},
        {Action::frame_back,
         [&] {
             playback_.pause();
             jump_back(interval_s);
         }},
        {Action::frame_on,
         [&] {
             playback_.pause();
             if (seeking_s_)
                 jump_on(interval_s);
             else
                 playback_.step();
         }},
        {Action::second_back, [&] { jump_back(jump_s); }},
        {Action::second_on, [&] { jump_on(jump_s); }},
        {Action::to_start, [&] { seek(loader_.first().time_s); }},
        {Action::darker, [&] { expose(-exposure_step_stops); }},
        {Action::brighter, [&] { expose(exposure_step_stops); }},
        {Action::split, [&] { split_ = split_ < 1 ? 1.0f : 0.5f; }},
        {Action::split_left, [&] { split_ = split_ < 1 ? std::max(0.0f, split_ - split_step) : 1; }},
        {Action::split_right, [&] { split_ = split_ < 1 ? std::min(0.999f, split_ + split_step) : 1; }},
        {Action::picture, [&] { picture_wanted_ = true; }},
        {Action::record_view, [&] { tell(recorder_->start_or_stop_view()); }},
        {Action::record_head, [&] { tell(recorder_->start_or_stop_head()); }},
        {Action::help, [&] { face_.turn_help_page(); }},
        {Action::open, [&] { face_.ask_for_source(); }},
        {Action::fullscreen,
         [&] {
             box_.ask_for_fullscreen_toggle();
             window_.wake();
         }},
        {Action::quit, [&] { quit_ = true; }},
    };
    try {
        if (const ShownSetting* setting = shown_setting_of(action); setting != nullptr)
            press(*setting);
        else if (const auto found = once.find(action); found != once.end())
            found->second();
    } catch (const std::exception& error) {
        tell(error.what());
    }
}

// What is said at the bottom.

/// What is to be said of a server that is late; empty: it is not.
std::string Presenter::lateness() const {
    if (playback_.attempts() > 0)
        return formatted("the connection was lost: trying again (%d)", playback_.attempts());
    if (const double overdue_s = playback_.overdue_s(); overdue_s > longest_unsaid_s)
        return formatted("waiting for the server since %.0f s", overdue_s);
    return "";
}

std::string Presenter::engine_in_use() const {
    return !draws_by_depth() || !renderer_->has_depth() ? "rotation"
           : renderer_->has_geometry()                  ? "eye-depth"
                                                        : shown_.engine;
}

/// Beside the time.
std::string Presenter::status() const {
    const std::string_view layout = is_worn_ ? "in the headset" : gl::display_layout_names[std::size_t(shown_.layout)];
    std::string line;
    if (truth_db_)
        line = formatted("truth on the right: %.1f dB  |  ", *truth_db_);
    line += in_words(is_worn_ ? seen_head_ : motion_.head()) + "  |  " + std::string(layout);
    if (headset_ != nullptr && !is_worn_)
        line += " (the headset is not worn)";
    line += ", " + engine_in_use() + (shown_.fill ? "" : ", gaps not filled");
    if (shown_.overlay != gl::Overlay::none)
        line += ", overlay " + std::string(gl::overlay_names[std::size_t(shown_.overlay)]);
    if (followed_.is_followed())
        line += ", the server follows this head";
    return line;
}

std::string Presenter::warning() const {
    if (const std::string late = lateness(); !late.empty())
        return late;
    if (now_s_ < message_until_s_)
        return message_;
    if (truth_ != nullptr && split_ < 1 && !why_no_truth().empty())
        return why_no_truth();
    if (beyond_head_box() > 0)
        return formatted("outside the head box of %.0f cm: parallax is beyond its error bound (c: back)",
                         100 * head_box_radius(frame().main.info));
    if (!frame().posed && frame().main.pq.empty() &&
        (loader_.has_transfer("smpte2084") || loader_.has_transfer("arib-std-b67")))
        return "HDR other than PQ by BT.2020 with even sides is shown as if it were not: dull";
    if (!frame().posed)
        return is_ods(frame().main.info.camera) ? "omnidirectional stereo: rotation only, no parallax"
               : frame().right                  ? "ordinary stereo video: rotation only, no parallax"
                                                : "ordinary video: rotation only";
    if (shown_.by_depth && !depth_problem_.empty())
        return depth_problem_ + ": rotation only, no parallax";
    if (shown_.by_depth && !renderer_->has_depth())
        return "no depth (--scene, --model or a depth track): rotation only, no parallax";
    return {};
}

}  // namespace equistream
