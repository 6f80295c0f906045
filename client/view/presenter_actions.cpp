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

template <typename Enum, std::size_t n>
Enum after(Enum value, const std::array<std::string_view, n>&) {
    return Enum((std::size_t(value) + 1) % n);
}

}  // namespace

void Presenter::tell(std::string message) {
    message_ = std::move(message);
    message_until_s_ = now_s_ + message_s;
}

void Presenter::seek(double time_s) {
    if (playback_.is_live())
        tell("there are no jumps in time in what comes live");
    else
        playback_.seek(time_s);
}

void Presenter::expose(double more_stops) {
    if (!exposure_stops_) {
        tell("exposure: no HDR stream");
        return;
    }
    exposure_stops_ = std::clamp(*exposure_stops_ + more_stops, -max_exposure_stops, max_exposure_stops);
    renderer_.set_exposure(*exposure_stops_);
    tell(formatted("exposure %+.2f stops", *exposure_stops_));
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
             seek(info.time_s - interval_s);
         }},
        {Action::frame_on,
         [&] {
             playback_.pause();
             playback_.step();
         }},
        {Action::second_back, [&] { seek(info.time_s - jump_s); }},
        {Action::second_on, [&] { seek(info.time_s + jump_s); }},
        {Action::to_start, [&] { seek(0); }},
        {Action::loop,
         [&] {
             settings_.loop = !settings_.loop;
             tell(settings_.loop ? "starts again at the end" : "stays at the end");
         }},
        {Action::next_layout, [&] { settings_.layout = after(settings_.layout, gl::display_layout_names); }},
        {Action::next_anaglyph,
         [&] {
             const auto at = std::size_t(settings_.anaglyph - anaglyphs().data());
             settings_.anaglyph = &anaglyphs()[(at + 1) % anaglyphs().size()];
             tell("anaglyph: " + std::string(settings_.anaglyph->name));
         }},
        {Action::next_overlay, [&] { settings_.overlay = after(settings_.overlay, gl::overlay_names); }},
        {Action::next_method, [&] { settings_.by_depth = !settings_.by_depth; }},
        {Action::fill, [&] { settings_.fill = !settings_.fill; }},
        {Action::darker, [&] { expose(-exposure_step_stops); }},
        {Action::brighter, [&] { expose(exposure_step_stops); }},
        {Action::split, [&] { split_ = split_ < 1 ? 1.0f : 0.5f; }},
        {Action::split_left, [&] { split_ = std::max(0.0f, split_ - split_step); }},
        {Action::split_right, [&] { split_ = std::min(0.999f, split_ + split_step); }},
        {Action::picture, [&] { picture_wanted_ = true; }},
        {Action::record_view, [&] { tell(recorder_.start_or_stop_view()); }},
        {Action::record_head, [&] { tell(recorder_.start_or_stop_head()); }},
        {Action::times, [&] { settings_.times = !settings_.times; }},
        {Action::help, [&] { panels_.turn_help_page(); }},
        {Action::fullscreen,
         [&] {
             box_.ask_for_fullscreen_toggle();
             window_.wake();
         }},
        {Action::quit, [&] { quit_ = true; }},
    };
    try {
        if (const auto found = once.find(action); found != once.end())
            found->second();
    } catch (const std::exception& error) {
        tell(error.what());
    }
}

// The line at the bottom.

/// What is to be said of a server that is late; empty: it is not.
std::string Presenter::lateness() const {
    if (playback_.attempts() > 0)
        return formatted("the connection was lost: trying again (%d)", playback_.attempts());
    if (const double overdue_s = playback_.overdue_s(); overdue_s > longest_unsaid_s)
        return formatted("waiting for the server since %.0f s", overdue_s);
    return "";
}

StatusLine Presenter::status() const {
    const FrameInfo& info = frame().main.info;
    StatusLine line;
    const std::string_view layout =
        is_worn_ ? "in the headset" : gl::display_layout_names[std::size_t(settings_.layout)];
    const std::string_view overlay = gl::overlay_names[std::size_t(settings_.overlay)];
    line.text = formatted(
        "%s frame %lld  %.2f s%s  |  %s  |  %.*s%s, %s%s%s%.*s  |  h: keys",
        playback_.is_paused() ? "paused" : "playing", static_cast<long long>(info.index), info.time_s,
        followed_.is_followed() ? ", the server follows" : "", in_words(is_worn_ ? seen_head_ : motion_.head()).c_str(),
        int(layout.size()), layout.data(), headset_ && !is_worn_ ? " (nobody wears the headset)" : "",
        !settings_.by_depth || !renderer_.has_depth() ? "rotation"
        : renderer_.has_geometry()                    ? "eye-depth"
                                                      : settings_.finding_engine.c_str(),
        settings_.fill ? "" : ", gaps open", settings_.overlay == gl::Overlay::none ? "" : ", overlay ",
        settings_.overlay == gl::Overlay::none ? 0 : int(overlay.size()), overlay.data());
    if (settings_.overlay == gl::Overlay::motion && settings_.layout != gl::DisplayLayout::sphere)
        line.legend = info.moving.empty()
                          ? "nothing is said to move"
                          : formatted("moves that way; %.0f deg/s at the rim", gl::full_motion_deg_per_s);
    line.decoder = frame().main.decoder;
    line.fraction_done = playback_.fraction_done();
    if (const std::string late = lateness(); !late.empty())
        line.warning = late;
    else if (now_s_ < message_until_s_)
        line.warning = message_;
    else if (truth_ != nullptr && split_ < 1 && !why_no_truth().empty())
        line.warning = why_no_truth();
    else if (const double fading = beyond_head_box(); fading > 0)
        line.warning = formatted("outside the head box of %.0f cm: parallax is beyond its error bound (c: back)",
                                 100 * head_box_radius(info));
    else if (!frame().posed && frame().main.pq.empty() &&
             (loader_.has_transfer("smpte2084") || loader_.has_transfer("arib-std-b67")))
        line.warning = "HDR other than PQ by BT.2020 with even sides is shown as if it were not: dull";
    else if (!frame().posed)
        line.warning = is_ods(frame().main.info.camera) ? "omnidirectional stereo, a sphere for each eye: rotation only"
                       : frame().right                  ? "ordinary stereo video, a sphere for each eye: rotation only"
                                                        : "ordinary video: rotation only";
    else if (!renderer_.has_depth())
        line.warning = "no --scene or --model, and no depth in the stream: rotation only";
    return line;
}

}  // namespace equistream
