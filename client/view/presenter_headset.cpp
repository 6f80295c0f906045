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

void Presenter::refresh_headset() {
    take_inputs();
    headset_->poll();
    quit_ = quit_ || headset_->is_over();
    if (!headset_->is_running()) {
        box_.wait(headset_idle_s);
        return;
    }
    const std::optional<HeadsetView> seen = headset_->begin_frame();
    now_s_ = loader_.now_s();
    times_.start(settings_.times);
    advance(now_s_);
    if (seen)
        draw_headset(*seen);
    headset_->end_frame();
}

void Presenter::draw_headset(const HeadsetView& seen) {
    const Pose middle = composed(followed_.around(), motion_.head());
    seen_head_ = composed(motion_.head(), seen.head);
    lead();
    recorder_.add_head(playback_.time_s(), head());
    std::array<EyeView, 2> eyes;
    for (std::size_t i = 0; i < eyes.size(); ++i)
        eyes[i] = {seen.view.camera, composed(middle, seen.eyes[i])};
    later_s_ = wanted_later_s();
    renderer_.carry_on(later_s_);
    renderer_.look(eyes, settings_.surface, times_);
    renderer_.draw(refresh_options(), targets_, times_);
    const GLuint framebuffer = headset_->framebuffer();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    display_.draw(
        {.eyes = &targets_,
         .depth = renderer_.depth(),
         .reliability = settings_.overlay == gl::Overlay::reliability ? renderer_.reliability() : 0,
         .motion = renderer_.motion(),
         .source = &renderer_.source()},
        {.layout = gl::DisplayLayout::side_by_side, .overlay = settings_.overlay, .fading = float(beyond_head_box())},
        headset_->size());
    times_.mark(gl::RenderStage::display);
    mirror(framebuffer, seen.view.parts[0]);
    ++report_.refreshes;
    report_.later_s += later_s_;
}

/// The window shows what the left eye sees.
void Presenter::mirror(GLuint framebuffer, const ViewPart& part) {
    const gl::Size window = inputs_.window;
    if (window.width == 0 || window.height == 0)
        return;
    const int bottom = headset_->size().height - part.top - part.height;
    glBlitNamedFramebuffer(framebuffer, 0, part.left, bottom, part.left + part.width, bottom + part.height, 0, 0,
                           window.width, window.height, GL_COLOR_BUFFER_BIT, GL_LINEAR);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    add_times();
    keep_what_is_asked_for();
    panels_.draw(status(), window, settings_.times);
    window_.show();
}

}  // namespace equistream
