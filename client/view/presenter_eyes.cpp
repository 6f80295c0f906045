/// What eyes see: from where they look, by what, and how that comes into the window.
#include "presenter.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <client/compare/picture_metrics.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace equistream {

double Presenter::wanted_extrapolation_s(double until_seen_s) const {
    // The truth is of the frames' own times.
    const bool is_extrapolated =
        settings_.extrapolation_limit_s > 0 && truth_ == nullptr && draws_by_depth() && renderer_->can_extrapolate();
    return is_extrapolated ? playback_.extrapolation_s(settings_.extrapolation_limit_s, until_seen_s) : 0;
}

Pose Presenter::head() const {
    return composed(followed_.around(), is_worn_ ? seen_head_ : motion_.head());
}

Pose Presenter::foretold_head() const {
    return composed(followed_.around(), seen_head_);
}

/// At the time of what is seen: after a jump that is the frame before, until the sought one comes.
void Presenter::record_head() {
    recorder_->add_head(playback_.shown_s() ? playback_.time_s() : frame().main.info.time_s, head());
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
    return {.surface = draws_by_depth(),
            .fill = shown_.fill,
            .reliability = shown_.overlay == gl::Overlay::reliability,
            .motion = shown_.overlay == gl::Overlay::motion,
            .right_alone = shown_.layout == gl::DisplayLayout::right,
            .mirrors = shown_.mirrors};
}

void Presenter::draw_eyes(gl::Size window, bool splits) {
    const gl::Size size = gl::eye_size(shown_.layout, window);
    const PerspectiveCamera camera{size.width, size.height, fov_deg_ * pi / 180};
    const Pose head = foretold_head();
    std::array<EyeView, gl::max_eyes> eyes;
    const int count = gl::eyes_of(shown_.layout);
    for (int i = 0; i < count; ++i) {
        const bool right = count == 1 ? shown_.layout == gl::DisplayLayout::right : i == 1;
        eyes[std::size_t(i)] = {camera,
                                {eye_position(head, right ? Eye::right : Eye::left, ipd_m()), head.orientation}};
    }
    eyes_ = eyes;
    poses_.look_through(camera);
    render_or_turn({eyes.data(), std::size_t(count)}, splits);
}

/// What these eyes see; where it `splits`, also by what is not chosen.
void Presenter::render(std::span<const EyeView> eyes, bool splits) {
    renderer_->extrapolate(extrapolation_s_);
    renderer_->look(eyes, draws_by_depth() || splits, times_);
    renderer_->draw(refresh_options(), targets_, times_);
    if (splits)
        renderer_->draw({.surface = !draws_by_depth(), .fill = shown_.fill, .mirrors = shown_.mirrors}, other_targets_,
                        times_);
}

/// What cannot be drawn by depth is turned, until another method is chosen.
void Presenter::render_or_turn(std::span<const EyeView> eyes, bool splits) {
    try {
        render(eyes, splits);
    } catch (const WorkError& error) {
        if (!draws_by_depth() && !splits)
            throw;
        depth_problem_ = error.what();
        tell(depth_problem_);
        render(eyes, false);
    }
}

/// Whether something else is shown right of the line: the truth, or what is not chosen.
bool Presenter::is_split() const {
    return shows_truth() || shows_other();
}

bool Presenter::shows_other() const {
    return split_ < 1 && truth_ == nullptr && renderer_->has_depth() && depth_problem_.empty();
}

void Presenter::look(gl::Size window) {
    const bool with_truth = shows_truth();
    eyes_.reset();
    if (shown_.layout != gl::DisplayLayout::sphere)
        draw_eyes(window, shows_other());
    truth_db_.reset();
    if (with_truth)
        put_truth_beside();
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    display_.draw({.eyes = &targets_,
                   .other = is_split() ? &other_targets_ : nullptr,
                   .depth = renderer_->depth(),
                   .reliability = shown_.overlay == gl::Overlay::reliability ? renderer_->reliability() : 0,
                   .motion = renderer_->motion(),
                   .source = &renderer_->source()},
                  {.layout = shown_.layout,
                   .anaglyph = shown_.anaglyph,
                   .overlay = shown_.overlay,
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
            tell(recorder_->keep_picture(read_back().view()));
        if (recorder_->records_view())
            recorder_->add_view(read_back().view());
    } catch (const std::exception& error) {
        tell(error.what());
    }
}

// What a headset shows, and the window beside it.

/// While the runtime wants no frames.
constexpr double headset_idle_s = 0.02;

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
        rest(refresh_window(), headset_idle_s);
        return;
    }
    if (resumes_)
        advance(now_s_);
    if (is_resuming()) {
        rest(false, headset_idle_s);  // a runtime without a new frame goes on with the last one
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
    times_.start(shown_.times);
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
    record_head();
    std::array<EyeView, 2> eyes;
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        eyes[i] = {seen.view.camera, composed(middle, seen.eyes[i])};
        worn_eyes_m_[i] = eyes[i].pose.position_m;
    }
    poses_.look_through(seen.view.camera);
    latency_.measured(seen.until_seen_s);
    extrapolation_s_ = wanted_extrapolation_s(seen.until_seen_s);
    eyes_.reset();  // of the window
    render_or_turn(eyes, false);
    glBindFramebuffer(GL_FRAMEBUFFER, headset_->framebuffer());
    display_.draw(
        {.eyes = &targets_,
         .depth = renderer_->depth(),
         .reliability = shown_.overlay == gl::Overlay::reliability ? renderer_->reliability() : 0,
         .motion = renderer_->motion(),
         .source = &renderer_->source()},
        {.layout = gl::DisplayLayout::side_by_side, .overlay = shown_.overlay, .fading = float(beyond_head_box())},
        headset_->size());
    times_.mark(gl::RenderStage::display);
    refreshes_.add(now_s_, 1);
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
    content_ = make_content();
    face_.say(content_);
    face_.draw();
    window_.show();
    drawn_.reset();
}

// Path-traced eyes beside what is drawn.

/// Whether there is another one to be seen, or none any more. What cannot be read is told once.
bool Presenter::find_truth() {
    if (truth_ == nullptr)
        return false;
    const Eye eye = shown_.layout == gl::DisplayLayout::right ? Eye::right : Eye::left;
    Truth::Found found = truth_->at(frame().main.info.time_s, eye);
    truth_is_coming_ = found.is_coming;
    if (!found.problem.empty() && found.problem != truth_problem_)
        tell(found.problem);
    truth_problem_ = std::move(found.problem);
    const bool is_other = found.eye != true_eye_;
    true_eye_ = std::move(found.eye);
    // While it comes the head stays: it does not go to the frame's own and back.
    if (true_eye_ || !truth_is_coming_ || report_.frames == 0)
        followed_.show(true_eye_ ? true_eye_->head : frame().main.info.head);
    return is_other;
}

/// Empty: the truth is of what is drawn.
std::string Presenter::why_no_truth() const {
    if (shown_.layout != gl::DisplayLayout::right && shown_.layout != gl::DisplayLayout::left)
        return "the truth needs one eye in the window (v)";
    if (!truth_problem_.empty())
        return truth_problem_;
    // A folder may hold fewer frames than are watched, and one eye of the two: said on the screen, as all of these are.
    if (!true_eye_)
        return truth_is_coming_ ? "the truth is being read" : "--truth has no frame of this eye at this time";
    const PerspectiveCamera& camera = true_eye_->camera;
    if (!(inputs_.window == gl::Size{camera.width, camera.height}))
        return formatted("the truth is %dx%d: make the window as large (--size)", camera.width, camera.height);
    if (std::abs(fov_deg_ - camera.fov_x_rad * 180 / pi) > 1e-6)
        return formatted("the truth is %s degrees wide: set --fov, or press c",
                         in_words(camera.fov_x_rad * 180 / pi).c_str());
    if (std::abs(ipd_m() - true_eye_->ipd_m) > 1e-6)
        return formatted("the truth's eyes are %s m apart: set --ipd", in_words(true_eye_->ipd_m).c_str());
    if (!same_pose(seen_head_, {}))
        return "the head is not where the truth is (c: back)";
    return "";
}

bool Presenter::shows_truth() const {
    return truth_ != nullptr && split_ < 1 && why_no_truth().empty();
}

/// Where the other method would be, and how near what is drawn is to it.
void Presenter::put_truth_beside() {
    const ByteImage& rgb = true_eye_->rgb;
    other_targets_.size_for(true_eye_->camera, 1);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTextureSubImage3D(other_targets_.colour(), 0, 0, 0, 0, rgb.width(), rgb.height(), 1, GL_RGB, GL_UNSIGNED_BYTE,
                        rgb.samples().data());
    targets_.download(0, seen_);
    truth_db_ = total_error(squared_errors(seen_.rgb().view(), rgb.view())).psnr_db();
    report_.truth_db = report_.truth_db.value_or(0) + *truth_db_;
    ++truth_count_;
}

}  // namespace equistream
