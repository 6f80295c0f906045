#include "viewer.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream_client/received_view.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace equistream {

namespace {

constexpr double message_s = 4, second_s = 1;
constexpr double zoom_step = 1.1, least_fov_deg = 10, most_fov_deg = 150;
constexpr float split_step = 0.05f;
/// After a pause of the whole program (a debugger, a closed lid) time goes on from where it was.
constexpr double longest_step_s = 0.25;

bool goes_on_by_repeats(Action action) {
    constexpr std::array repeated = {Action::frame_back, Action::frame_on,   Action::second_back,
                                     Action::second_on,  Action::split_left, Action::split_right};
    return std::ranges::find(repeated, action) != repeated.end();
}

template <typename Enum, std::size_t n>
Enum after(Enum value, const std::array<std::string_view, n>&) {
    return Enum((std::size_t(value) + 1) % n);
}

/// Main's depth comes from geometry or not at all, the second eye is drawn like the first, mirrors as if painted.
TrackRoles unused_roles() {
    TrackRoles roles;
    for (const TrackRole role : {TrackRole::small, TrackRole::depth, TrackRole::images})
        roles.set(std::size_t(role));
    return roles;
}

}  // namespace

Viewer::Viewer(const ViewerSettings& settings)
    : settings_(settings),
      loader_(settings.source,
              {.depth = true, .yuv = true, .left_out = [] { return unused_roles(); }, .poses = &poses_}),
      recorder_(settings.out) {
    const FrameInfo& first = loader_.first();
    window_ = Window::open("equistream: " + settings_.source, settings_.size);
    renderer_ =
        std::make_unique<gl::EyeRenderer>(settings_.scene ? &*settings_.scene : nullptr, head_box_radius(first));
    display_.emplace();
    panels_.emplace(*window_);
    time_s_ = first.time_s;
    show(loader_.next());
}

Viewer::~Viewer() = default;

void Viewer::run() {
    auto last = Clock::now();
    for (bool goes_on = true; goes_on;) {
        const double seconds = seconds_since(last);
        last = Clock::now();
        goes_on = refresh(seconds);
    }
}

bool Viewer::refresh(double since_last_s) {
    run_s_ += since_last_s;
    const double seconds = std::min(since_last_s, longest_step_s);
    const Inputs inputs = window_->poll();
    for (const KeyPress& press : inputs.pressed)
        if (const KeyBinding* binding = binding_of(press.key, press.modifiers);
            binding != nullptr && !is_held(binding->action) && (!press.repeated || goes_on_by_repeats(binding->action)))
            act(binding->action);
    steer(inputs, seconds);
    const gl::Size window = window_->size();
    if (window.width == 0 || window.height == 0) {
        window_->wait(0.1);  // minimised: nobody sees anything
    } else {
        times_.start(settings_.times);
        advance(seconds);
        lead();
        look(window);
        const double refresh_ms = 1e3 * since_last_s;
        if (settings_.times)
            panels_->add(times_.row(), refresh_ms);
        recorder_.add_head(time_s_, head());
        keep_what_is_asked_for();
        panels_->draw(status(), settings_.help, settings_.times);
        window_->show();
    }
    const bool over = settings_.seconds > 0 && run_s_ >= settings_.seconds;
    return !(quit_ || over || window_->should_close());
}

void Viewer::keep_what_is_asked_for() {
    try {
        if (std::exchange(picture_wanted_, false))
            tell(recorder_.keep_picture(read_back().view()));
        if (recorder_.records_view())
            recorder_.add_view(read_back().view());
    } catch (const std::exception& error) {
        tell(error.what());
    }
}

void Viewer::steer(const Inputs& inputs, double seconds) {
    Steering steering;
    for (const KeyBinding& binding : key_bindings())
        if (is_held(binding.action) && binding.modifiers == 0 && window_->is_down(binding.key) &&
            !window_->is_down(GLFW_KEY_LEFT_SHIFT) && !window_->is_down(GLFW_KEY_RIGHT_SHIFT))
            steering.held.set(std::size_t(binding.action));
    const Sticks sticks = window_->sticks();
    steering.turn_x = sticks.turn_x;
    steering.turn_y = sticks.turn_y;
    steering.move_x = sticks.move_x;
    steering.move_y = sticks.move_y;
    steering.move_z = sticks.move_z;
    // What the mouse holds in the middle of a picture stays under it.
    const double eye_px = std::max(1, gl::eye_size(settings_.layout, window_->size()).width);
    const double rad_per_px = 2 * std::tan(settings_.fov_deg * pi / 360) / eye_px;
    steering.drag_yaw_rad = inputs.drag_x * rad_per_px;
    steering.drag_pitch_rad = inputs.drag_y * rad_per_px;
    navigator_.steer(steering, seconds);
    settings_.fov_deg =
        std::clamp(settings_.fov_deg * std::pow(zoom_step, -inputs.scroll), least_fov_deg, most_fov_deg);
    if (inputs.click_x >= 0 && split_ < 1)
        split_ = float(std::clamp(inputs.click_x, 0.0, 0.999));
}

/// A head that only turns leaves the server its own path: a sphere has all directions.
void Viewer::lead() {
    const bool has_moved = navigator_.offset_m() != glm::dvec3(0);
    if ((has_moved || followed_.is_followed()) && poses_.send({frame().main.info.time_s, head()}))
        followed_.sent(head());
}

void Viewer::advance(double seconds) {
    try {
        if (stepping_)
            step();
        else if (!settings_.paused)
            play(seconds);
    } catch (const std::exception& error) {
        // What was shown last stays.
        tell(error.what());
        stepping_ = false;
        settings_.paused = true;
    }
}

void Viewer::step() {
    if (SharedFrame frame = loader_.next()) {
        time_s_ = frame->main.info.time_s;
        show(std::move(frame));
        stepping_ = false;
    } else if (loader_.at_end()) {
        end();
    }
}

void Viewer::play(double seconds) {
    const FrameInfo& info = frame().main.info;
    const double interval_s = info.frames_per_second > 0 ? 1 / info.frames_per_second : 0;
    time_s_ += seconds;
    // Where decoding does not keep up, time waits for it.
    if (!loader_.is_ready() && !loader_.at_end())
        time_s_ = std::min(time_s_, info.time_s + interval_s);
    // A server that leaves frames out renders them while they are watched: the newest is the one to see.
    const bool is_live = is_served() && loader_.has_gaps();
    if (SharedFrame next = loader_.due(is_live ? std::numeric_limits<double>::infinity() : time_s_)) {
        time_s_ = std::max(time_s_, next->main.info.time_s);
        show(std::move(next));
    } else if (loader_.at_end() && time_s_ >= info.time_s + interval_s) {
        end();
    }
}

void Viewer::end() {
    stepping_ = false;
    if (!loader_.truncation().empty())
        tell(loader_.truncation());
    // A server is not asked again and again: who comes back to its address begins anew.
    if (settings_.loop && !settings_.paused && !is_served())
        seek(0);
    else
        settings_.paused = true;
}

void Viewer::show(SharedFrame frame) {
    followed_.show(frame->main.info.head);
    renderer_->show(std::move(frame), times_);
}

void Viewer::seek(double time_s) {
    const FrameInfo& first = loader_.first();
    const double wanted = std::max(time_s, first.time_s);
    loader_.seek(first.index + std::int64_t(std::llround((wanted - first.time_s) * first.frames_per_second)));
    time_s_ = wanted;
    stepping_ = true;
}

void Viewer::tell(std::string message) {
    message_ = std::move(message);
    message_until_s_ = run_s_ + message_s;
}

void Viewer::act(Action action) {
    const FrameInfo& info = frame().main.info;
    const double interval_s = 1 / std::max(1.0, info.frames_per_second);
    try {
        switch (action) {
        case Action::centre:
            navigator_.centre();
            break;
        case Action::play_pause:
            settings_.paused = !settings_.paused;
            if (!settings_.paused && loader_.at_end())
                seek(0);
            break;
        case Action::frame_back:
            settings_.paused = true;
            seek(info.time_s - interval_s);
            break;
        case Action::frame_on:
            settings_.paused = true;
            stepping_ = true;
            break;
        case Action::second_back:
            seek(info.time_s - second_s);
            break;
        case Action::second_on:
            seek(info.time_s + second_s);
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
            settings_.surface = !settings_.surface;
            break;
        case Action::fill:
            settings_.fill = !settings_.fill;
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
            settings_.help = !settings_.help;
            break;
        case Action::fullscreen:
            window_->toggle_fullscreen();
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

Pose Viewer::head() const {
    return navigator_.head(followed_.around());
}

double Viewer::beyond_head_box() const {
    const FrameInfo& info = frame().main.info;
    if (!frame().posed)
        return 0;
    double farthest_m = 0;
    for (const Eye eye : {Eye::left, Eye::right})
        farthest_m = std::max(farthest_m, glm::distance(eye_position(head(), eye, settings_.ipd_m.value_or(info.ipd_m)),
                                                        info.camera_pose.position_m));
    return head_box_fading(farthest_m, head_box_radius(info) + 1e-6);
}

void Viewer::draw_eyes(gl::Size window, bool splits) {
    const FrameInfo& info = frame().main.info;
    const gl::Size size = gl::eye_size(settings_.layout, window);
    const PerspectiveCamera camera{size.width, size.height, settings_.fov_deg * pi / 180};
    const double ipd_m = settings_.ipd_m.value_or(info.ipd_m);
    std::array<EyeView, gl::most_eyes> eyes;
    const int count = gl::eyes_of(settings_.layout);
    for (int i = 0; i < count; ++i) {
        const bool right = count == 1 ? settings_.layout == gl::DisplayLayout::right : i == 1;
        eyes[std::size_t(i)] = {camera,
                                {eye_position(head(), right ? Eye::right : Eye::left, ipd_m), head().orientation}};
    }
    renderer_->look({eyes.data(), std::size_t(count)}, settings_.surface || splits, times_);
    const gl::RefreshOptions options{.surface = settings_.surface,
                                     .fill = settings_.fill,
                                     .reliability = settings_.overlay == gl::Overlay::reliability};
    renderer_->draw(options, targets_, times_);
    if (splits)
        renderer_->draw({.surface = !settings_.surface, .fill = settings_.fill}, other_targets_, times_);
}

void Viewer::look(gl::Size window) {
    const bool splits = split_ < 1 && renderer_->has_depth();
    if (settings_.layout != gl::DisplayLayout::sphere)
        draw_eyes(window, splits);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    display_->draw({.eyes = &targets_,
                    .other = splits ? &other_targets_ : nullptr,
                    .depth = renderer_->depth(),
                    .reliability = settings_.overlay == gl::Overlay::reliability ? renderer_->reliability() : 0,
                    .source = &renderer_->source()},
                   {.layout = settings_.layout,
                    .anaglyph = settings_.anaglyph,
                    .overlay = settings_.overlay,
                    .fading = float(beyond_head_box()),
                    .split = split_},
                   window);
    times_.mark(gl::RenderStage::display);
}

StatusLine Viewer::status() const {
    const FrameInfo& info = frame().main.info;
    const glm::dvec3 offset = 100.0 * navigator_.offset_m();
    StatusLine line;
    const std::string_view layout = gl::display_layout_names[std::size_t(settings_.layout)];
    const std::string_view overlay = gl::overlay_names[std::size_t(settings_.overlay)];
    line.text = formatted(
        "%s frame %lld  %.2f s%s  |  yaw %.0f pitch %.0f deg, head %.0f %.0f %.0f cm  |  %.*s, %s%s%s%.*s  |  h: keys",
        settings_.paused ? "paused" : "playing", static_cast<long long>(info.index), info.time_s,
        followed_.is_followed() ? ", the server follows" : "", navigator_.yaw_rad() * 180 / pi,
        navigator_.pitch_rad() * 180 / pi, offset.x, offset.y, offset.z, int(layout.size()), layout.data(),
        settings_.surface && renderer_->has_depth() ? "surface" : "sphere", settings_.fill ? "" : ", gaps open",
        settings_.overlay == gl::Overlay::none ? "" : ", overlay ",
        settings_.overlay == gl::Overlay::none ? 0 : int(overlay.size()), overlay.data());
    line.fraction_done = loader_.fraction_done();
    if (run_s_ < message_until_s_)
        line.warning = message_;
    else if (const double fading = beyond_head_box(); fading > 0)
        line.warning = formatted("outside the head box of %.0f cm: parallax is beyond its error bound (c: back)",
                                 100 * head_box_radius(info));
    else if (!frame().posed)
        line.warning = "ordinary video: rotation only";
    else if (!renderer_->has_geometry())
        line.warning = "no --scene or --model: rotation only";
    return line;
}

ByteImage Viewer::read_back() const {
    const gl::Size size = window_->size();
    ByteImage rows_up(size.width, size.height, 3), picture(size.width, size.height, 3);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glReadBuffer(GL_BACK);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, size.width, size.height, GL_RGB, GL_UNSIGNED_BYTE, rows_up.samples().data());
    for (int y = 0; y < size.height; ++y)
        std::copy_n(rows_up.pixel(0, size.height - 1 - y), std::size_t(3) * std::size_t(size.width),
                    picture.pixel(0, y));
    return picture;
}

}  // namespace equistream
