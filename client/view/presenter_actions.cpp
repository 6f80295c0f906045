#include "presenter.h"

#include <equistream/formatted.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace equistream {

namespace {

constexpr double message_s = 4, second_s = 1;
constexpr float split_step = 0.05f;
constexpr double exposure_step_stops = 0.25;

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
    try {
        switch (action) {
        case Action::centre:
            motion_.centre();
            fov_deg_ = first_fov_deg();
            if (headset_)
                headset_->recentre();
            break;
        case Action::play_pause:
            if (playback_.is_paused())
                playback_.play();
            else
                playback_.pause();
            break;
        case Action::frame_back:
            playback_.pause();
            seek(info.time_s - interval_s);
            break;
        case Action::frame_on:
            playback_.pause();
            playback_.step();
            break;
        case Action::second_back:
            seek(info.time_s - jump_s);
            break;
        case Action::second_on:
            seek(info.time_s + jump_s);
            break;
        case Action::to_start:
            seek(0);
            break;
        case Action::loop:
            settings_.loop = !settings_.loop;
            tell(settings_.loop ? "starts again at the end" : "stays at the end");
            break;
        case Action::next_layout:
            settings_.layout = after(settings_.layout, gl::display_layout_names);
            break;
        case Action::next_anaglyph: {
            const auto kinds = anaglyphs();
            const auto at = std::size_t(settings_.anaglyph - kinds.data());
            settings_.anaglyph = &kinds[(at + 1) % kinds.size()];
            tell("anaglyph: " + std::string(settings_.anaglyph->name));
            break;
        }
        case Action::next_overlay:
            settings_.overlay = after(settings_.overlay, gl::overlay_names);
            break;
        case Action::next_method:
            settings_.by_depth = !settings_.by_depth;
            break;
        case Action::fill:
            settings_.fill = !settings_.fill;
            break;
        case Action::darker:
            expose(-exposure_step_stops);
            break;
        case Action::brighter:
            expose(exposure_step_stops);
            break;
        case Action::split:
            split_ = split_ < 1 ? 1.0f : 0.5f;
            break;
        case Action::split_left:
            split_ = std::max(0.0f, split_ - split_step);
            break;
        case Action::split_right:
            split_ = std::min(0.999f, split_ + split_step);
            break;
        case Action::picture:
            picture_wanted_ = true;
            break;
        case Action::record_view:
            tell(recorder_.start_or_stop_view());
            break;
        case Action::record_head:
            tell(recorder_.start_or_stop_head());
            break;
        case Action::times:
            settings_.times = !settings_.times;
            break;
        case Action::help:
            panels_.turn_help_page();
            break;
        case Action::fullscreen:
            box_.ask_for_fullscreen_toggle();
            window_.wake();
            break;
        case Action::quit:
            quit_ = true;
            break;
        default:
            break;  // held: steer's
        }
    } catch (const std::exception& error) {
        tell(error.what());
    }
}

}  // namespace equistream
