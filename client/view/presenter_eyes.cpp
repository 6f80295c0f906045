/// What eyes see: from where they look, by what, and how that comes into the window.
#include "presenter.h"

#include <client/receive/received_view.h>
#include <client/warp/engine.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace equistream {

double Presenter::wanted_extrapolation_s(double until_seen_s) const {
    // The truth is of the frames' own times.
    const bool is_extrapolated =
        settings_.extrapolation_limit_s > 0 && truth_ == nullptr && settings_.by_depth && renderer_.can_extrapolate();
    return is_extrapolated ? playback_.extrapolation_s(settings_.extrapolation_limit_s, until_seen_s) : 0;
}

Pose Presenter::head() const {
    return composed(followed_.around(), is_worn_ ? seen_head_ : motion_.head());
}

Pose Presenter::foretold_head() const {
    return composed(followed_.around(), seen_head_);
}

double Presenter::ipd_m() const {
    return settings_.ipd_m.value_or(true_eye_ ? true_eye_->ipd_m : frame().main.info.ipd_m);
}

std::array<glm::dvec3, 2> Presenter::eyes_m() const {
    if (is_worn_)
        return worn_eyes_m_;
    return {eye_position(foretold_head(), Eye::left, ipd_m()), eye_position(foretold_head(), Eye::right, ipd_m())};
}

double Presenter::beyond_head_box() const {
    const FrameInfo& info = frame().main.info;
    if (!frame().posed)
        return 0;
    double farthest_m = 0;
    for (const glm::dvec3& eye_m : eyes_m())
        farthest_m = std::max(farthest_m, glm::distance(eye_m, info.camera_pose.position_m));
    return head_box_fading(farthest_m, head_box_radius(info) + 1e-6);
}

gl::RefreshOptions Presenter::refresh_options() const {
    return {.surface = settings_.by_depth,
            .fill = settings_.fill,
            .reliability = settings_.overlay == gl::Overlay::reliability,
            .motion = settings_.overlay == gl::Overlay::motion,
            .right_alone = settings_.layout == gl::DisplayLayout::right,
            .mirrors = settings_.mirrors};
}

void Presenter::draw_eyes(gl::Size window, bool splits) {
    const gl::Size size = gl::eye_size(settings_.layout, window);
    const PerspectiveCamera camera{size.width, size.height, fov_deg_ * pi / 180};
    const Pose head = foretold_head();
    std::array<EyeView, gl::max_eyes> eyes;
    const int count = gl::eyes_of(settings_.layout);
    for (int i = 0; i < count; ++i) {
        const bool right = count == 1 ? settings_.layout == gl::DisplayLayout::right : i == 1;
        eyes[std::size_t(i)] = {camera,
                                {eye_position(head, right ? Eye::right : Eye::left, ipd_m()), head.orientation}};
    }
    renderer_.extrapolate(extrapolation_s_);
    renderer_.look({eyes.data(), std::size_t(count)}, settings_.by_depth || splits, times_);
    renderer_.draw(refresh_options(), targets_, times_);
    if (splits)
        renderer_.draw({.surface = !settings_.by_depth, .fill = settings_.fill, .mirrors = settings_.mirrors},
                       other_targets_, times_);
}

void Presenter::look(gl::Size window) {
    const bool with_truth = shows_truth();
    const bool with_other = split_ < 1 && truth_ == nullptr && renderer_.has_depth();
    const bool splits = with_truth || with_other;
    if (settings_.layout != gl::DisplayLayout::sphere)
        draw_eyes(window, with_other);
    truth_db_.reset();
    if (with_truth)
        put_truth_beside();
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    display_.draw({.eyes = &targets_,
                   .other = splits ? &other_targets_ : nullptr,
                   .depth = renderer_.depth(),
                   .reliability = settings_.overlay == gl::Overlay::reliability ? renderer_.reliability() : 0,
                   .motion = renderer_.motion(),
                   .source = &renderer_.source()},
                  {.layout = settings_.layout,
                   .anaglyph = settings_.anaglyph,
                   .overlay = settings_.overlay,
                   .fading = float(beyond_head_box()),
                   .split = split_},
                  window);
    times_.mark(gl::RenderStage::display);
}

ByteImage Presenter::read_back() const {
    const gl::Size size = inputs_.window;
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

void Presenter::keep_what_is_asked_for() {
    try {
        if (std::exchange(picture_wanted_, false))
            tell(recorder_.keep_picture(read_back().view()));
        if (recorder_.records_view())
            recorder_.add_view(read_back().view());
    } catch (const std::exception& error) {
        tell(error.what());
    }
}

}  // namespace equistream
