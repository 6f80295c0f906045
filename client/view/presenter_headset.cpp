/// What a headset shows, and the window beside it.
#include "presenter.h"

#include <algorithm>
#include <array>
#include <utility>

namespace equistream {

namespace {

/// While the runtime wants no frames.
constexpr double headset_idle_s = 0.02;

}  // namespace

/// While nobody looks into it the window shows what it would without one.
void Presenter::refresh_headset() {
    take_inputs();
    headset_->poll();
    if (headset_->is_over()) {
        quit_ = true;
        return;
    }
    if (!headset_->is_running()) {
        is_worn_ = false;
        if (!refresh_window())
            box_.wait(headset_idle_s);
        return;
    }
    const std::optional<HeadsetView> seen = headset_->begin_frame();
    is_worn_ = seen.has_value();
    now_s_ = loader_.now_s();
    if (!seen) {
        headset_->end_frame();
        refresh_window();
        return;
    }
    times_.start(settings_.times);
    advance(now_s_);
    draw_headset(*seen);
    mirror(headset_->framebuffer(), seen->view.parts[0]);
    // What may take longer than a frame comes after it.
    headset_->end_frame();
    show_mirror();
}

void Presenter::draw_headset(const HeadsetView& seen) {
    const Pose middle = composed(followed_.around(), motion_.head());
    seen_head_ = composed(motion_.head(), seen.head);
    lead();
    recorder_.add_head(playback_.time_s(), head());
    std::array<EyeView, 2> eyes;
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        eyes[i] = {seen.view.camera, composed(middle, seen.eyes[i])};
        worn_eyes_m_[i] = eyes[i].pose.position_m;
    }
    latency_.measured(seen.until_seen_s);
    extrapolation_s_ = wanted_extrapolation_s(seen.until_seen_s);
    renderer_.extrapolate(extrapolation_s_);
    renderer_.look(eyes, settings_.by_depth, times_);
    renderer_.draw(refresh_options(), targets_, times_);
    glBindFramebuffer(GL_FRAMEBUFFER, headset_->framebuffer());
    display_.draw(
        {.eyes = &targets_,
         .depth = renderer_.depth(),
         .reliability = settings_.overlay == gl::Overlay::reliability ? renderer_.reliability() : 0,
         .motion = renderer_.motion(),
         .source = &renderer_.source()},
        {.layout = gl::DisplayLayout::side_by_side, .overlay = settings_.overlay, .fading = float(beyond_head_box())},
        headset_->size());
    times_.mark(gl::RenderStage::display);
    ++report_.refreshes;
    report_.extrapolation_s += extrapolation_s_;
}

/// What the left eye sees goes into the window's buffer while there is a picture of it.
void Presenter::mirror(GLuint framebuffer, const ViewPart& part) {
    const gl::Size window = inputs_.window;
    if (window.width == 0 || window.height == 0)
        return;
    const int bottom = headset_->size().height - part.top - part.height;
    glBlitNamedFramebuffer(framebuffer, 0, part.left, bottom, part.left + part.width, bottom + part.height, 0, 0,
                           window.width, window.height, GL_COLOR_BUFFER_BIT, GL_LINEAR);
}

void Presenter::show_mirror() {
    add_times();
    if (inputs_.window.width == 0 || inputs_.window.height == 0)
        return;  // minimised
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    keep_what_is_asked_for();
    panels_.draw(status(), inputs_.window, settings_.times);
    window_.show();
    drawn_.reset();
}

}  // namespace equistream
