/// The line at the bottom.
#include "presenter.h"

#include <client/receive/received_view.h>
#include <equistream/formatted.h>

#include <string>
#include <string_view>

namespace equistream {

namespace {

/// What is less late shows itself by nothing but pictures that come late.
constexpr double longest_unsaid_s = 0.5;

}  // namespace

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
        line.warning = frame().right ? "ordinary stereo video, a sphere for each eye: rotation only"
                                     : "ordinary video: rotation only";
    else if (!renderer_.has_depth())
        line.warning = "no --scene or --model, and no depth in the stream: rotation only";
    return line;
}

}  // namespace equistream
