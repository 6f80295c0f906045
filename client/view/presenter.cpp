#include "presenter.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream_client/engine.h>
#include <equistream_client/received_view.h>
#include <equistream_compare/picture_metrics.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>

namespace equistream {

namespace {

constexpr double zoom_step = 1.1, least_fov_deg = 10, most_fov_deg = 150;
/// Without anything to show; what happens meanwhile ends it.
constexpr double longest_idle_s = 0.5;
/// A refresh that took longer made something for the first time.
constexpr double longest_latency_s = 0.25;
/// Of a display's interval: swaps of one that waits for its refreshes keep the pace by themselves, of others this does.
constexpr double least_interval = 0.9;

}  // namespace

Presenter::Presenter(const ViewerSettings& settings, Truth* truth, FrameLoader& loader, PoseSender& poses,
                     InputBox& box, Window& window)
    : settings_(settings), truth_(truth),
      fov_deg_(
          settings.fov_deg.value_or(truth != nullptr ? truth->camera().fov_x_rad * 180 / pi : default_view_fov_deg)),
      loader_(loader), poses_(poses), box_(box), window_(window), playback_(loader, settings.paused),
      headset_(settings.headset ? std::make_unique<Headset>() : nullptr),
      renderer_(settings_.scene ? &*settings_.scene : nullptr, head_box_radius(loader.first()), settings_.rungs),
      recorder_(settings.out), began_s_(loader.now_s()), now_s_(began_s_) {
    advance(now_s_);
}

Presenter::~Presenter() = default;

bool Presenter::is_over() const {
    return quit_ || inputs_.is_closed || (settings_.seconds > 0 && now_s_ - began_s_ >= settings_.seconds);
}

void Presenter::run() {
    if (headset_)
        window_.do_not_wait_for_refreshes();  // the headset has its own
    while (!is_over()) {
        if (headset_) {
            refresh_headset();
            continue;
        }
        const bool drew = refresh();
        rest(drew);
    }
}

void Presenter::take_inputs() {
    now_s_ = loader_.now_s();
    box_.take(inputs_);
    for (const Action action : inputs_.pressed)
        act(action);
    steer(now_s_);
}

/// Whether there was anything to draw.
bool Presenter::refresh() {
    take_inputs();
    if (inputs_.window.width == 0 || inputs_.window.height == 0)
        return false;  // minimised: nobody sees anything
    times_.start(settings_.times);
    const bool is_new = advance(now_s_);
    lead();
    seen_head_ = motion_.predict(settings_.predict_s.value_or(latency_.seconds()));
    later_s_ = wanted_later_s();
    recorder_.add_head(playback_.time_s(), head());
    StatusLine status = this->status();
    if (!is_new && !inputs_.any && !picture_wanted_ && !recorder_.records_view() &&
        same_pose(seen_head_, drawn_head_) && later_s_ == drawn_later_s_ && status == drawn_status_)
        return false;
    draw(status);
    drawn_head_ = seen_head_;
    drawn_later_s_ = later_s_;
    drawn_status_ = std::move(status);
    return true;
}

void Presenter::draw(const StatusLine& status) {
    look(inputs_.window);
    add_times();
    keep_what_is_asked_for();
    StatusLine line = status;
    if (truth_db_)
        line.text = formatted("truth on the right: %.1f dB  |  ", *truth_db_) + line.text;  // small windows cut its end
    panels_.draw(line, inputs_.window, settings_.times);
    window_.show();
    ++report_.refreshes;
    report_.later_s += later_s_;
    if (const double latency_s = loader_.now_s() - now_s_; latency_s < longest_latency_s)
        latency_.measured(latency_s);
}

void Presenter::add_times() {
    const double since_last_s = now_s_ - std::exchange(drawn_s_, now_s_);
    if (!settings_.times)
        return;
    panels_.add(times_.row(), 1e3 * since_last_s);
    report_.stages_ms = report_.stages_ms.value_or(gl::StageTimes::Row{});
    for (std::size_t stage = 0; stage < times_.row().size(); ++stage)
        (*report_.stages_ms)[stage] += times_.row()[stage];
}

/// Until the next refresh may have something to draw.
void Presenter::rest(bool drew) {
    if (!drew && !playback_.is_moving() && motion_.is_resting()) {
        box_.wait(longest_idle_s);
        return;
    }
    const double left_s = least_interval / window_.refresh_hz() - (loader_.now_s() - now_s_);
    if (left_s > 0)
        std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
}

void Presenter::steer(double now_s) {
    // What the mouse holds in the middle of a picture stays under it.
    const double eye_px = std::max(1, gl::eye_size(settings_.layout, inputs_.window).width);
    const double rad_per_px = 2 * std::tan(fov_deg_ * pi / 360) / eye_px;
    for (const InputSample& sample : inputs_.samples) {
        steering_.drag_yaw_rad = sample.drag_x * rad_per_px;
        steering_.drag_pitch_rad = sample.drag_y * rad_per_px;
        motion_.steer(steering_, sample.time_s);
        steering_ = {.held = sample.held,
                     .turn_x = sample.sticks.turn_x,
                     .turn_y = sample.sticks.turn_y,
                     .move_x = sample.sticks.move_x,
                     .move_y = sample.sticks.move_y,
                     .move_z = sample.sticks.move_z};
    }
    motion_.steer(steering_, now_s);
    fov_deg_ = std::clamp(fov_deg_ * std::pow(zoom_step, -inputs_.scroll), least_fov_deg, most_fov_deg);
    if (inputs_.click_x >= 0 && split_ < 1)
        split_ = float(std::clamp(inputs_.click_x, 0.0, 0.999));
}

/// Whether another frame is shown.
bool Presenter::advance(double now_s) {
    bool is_new = false;
    try {
        const Playback::Moment moment = playback_.refresh(now_s);
        if (moment.frame) {
            if (truth_ != nullptr)
                true_eyes_ = truth_->at(moment.frame->main.info.time_s);
            followed_.show(true_eyes_ != nullptr ? true_eyes_->head : moment.frame->main.info.head);
            show(moment.frame);
            ++report_.frames;
            report_.decode_ms += moment.frame->main.decode_ms;
            is_new = true;
        }
        if (moment.is_over)
            end();
    } catch (const std::exception& error) {
        if (report_.frames == 0)
            throw;
        // What was shown last stays.
        tell(error.what());
        playback_.pause();
    }
    log_connection();
    return is_new;
}

/// HDR pictures need a shader, which is made when the first one comes, on whatever track.
void Presenter::show(SharedFrame frame) {
    const auto is_hdr = [](const std::optional<ReceivedPicture>& picture) { return picture && !picture->pq.empty(); };
    if (!exposure_stops_ &&
        (!frame->main.pq.empty() || is_hdr(frame->hidden) || is_hdr(frame->small) || is_hdr(frame->patches))) {
        const auto display = settings_.hdr_display ? settings_.hdr_display : std::make_shared<const HdrDisplay>();
        renderer_.show_pq_by(std::make_shared<gl::PqDisplay>(*display));
        exposure_stops_ = display->settings().exposure_stops;
    }
    renderer_.show(std::move(frame), times_);
}

void Presenter::end() {
    if (!loader_.truncation().empty())
        tell(loader_.truncation());
    if (settings_.loop && !playback_.is_paused() && !playback_.is_live())
        playback_.seek(loader_.first().time_s);
    else
        playback_.pause();
}

/// One line when a server is lost, and one when it is there again.
void Presenter::log_connection() {
    const bool is_lost = playback_.attempts() > 0;
    if (is_lost != std::exchange(was_lost_, is_lost))
        std::fprintf(stderr, "%s: %s\n", settings_.source.c_str(),
                     is_lost ? "the connection was lost; trying again" : "connected again");
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

/// A head that only turns leaves the server its own path: a sphere has all directions.
void Presenter::lead() {
    const bool has_moved = motion_.navigator().offset_m() != glm::dvec3(0);
    if ((has_moved || followed_.is_followed()) && poses_.send({frame().main.info.time_s, head()}))
        followed_.sent(head());
}

double Presenter::wanted_later_s() const {
    // The truth is of the frames' own times.
    const bool is_carried = settings_.carry_s > 0 && truth_ == nullptr && settings_.surface && renderer_.can_carry_on();
    return is_carried ? playback_.later_s(settings_.carry_s, latency_.seconds()) : 0;
}

Pose Presenter::head() const {
    return composed(followed_.around(), headset_ ? seen_head_ : motion_.head());
}

Pose Presenter::foretold_head() const {
    return composed(followed_.around(), seen_head_);
}

double Presenter::ipd_m() const {
    return settings_.ipd_m.value_or(true_eyes_ != nullptr ? true_eyes_->ipd_m : frame().main.info.ipd_m);
}

double Presenter::beyond_head_box() const {
    const FrameInfo& info = frame().main.info;
    if (!frame().posed)
        return 0;
    double farthest_m = 0;
    for (const Eye eye : {Eye::left, Eye::right})
        farthest_m = std::max(farthest_m,
                              glm::distance(eye_position(foretold_head(), eye, ipd_m()), info.camera_pose.position_m));
    return head_box_fading(farthest_m, head_box_radius(info) + 1e-6);
}

gl::RefreshOptions Presenter::refresh_options() const {
    return {.surface = settings_.surface,
            .fill = settings_.fill,
            .reliability = settings_.overlay == gl::Overlay::reliability,
            .motion = settings_.overlay == gl::Overlay::motion,
            .mirrors = settings_.mirrors};
}

void Presenter::draw_eyes(gl::Size window, bool splits) {
    const gl::Size size = gl::eye_size(settings_.layout, window);
    const PerspectiveCamera camera{size.width, size.height, fov_deg_ * pi / 180};
    const Pose head = foretold_head();
    std::array<EyeView, gl::most_eyes> eyes;
    const int count = gl::eyes_of(settings_.layout);
    for (int i = 0; i < count; ++i) {
        const bool right = count == 1 ? settings_.layout == gl::DisplayLayout::right : i == 1;
        eyes[std::size_t(i)] = {camera,
                                {eye_position(head, right ? Eye::right : Eye::left, ipd_m()), head.orientation}};
    }
    renderer_.carry_on(later_s_);
    renderer_.look({eyes.data(), std::size_t(count)}, settings_.surface || splits, times_);
    renderer_.draw(refresh_options(), targets_, times_);
    if (splits)
        renderer_.draw({.surface = !settings_.surface, .fill = settings_.fill, .mirrors = settings_.mirrors},
                       other_targets_, times_);
}

/// Empty: the truth is of what is drawn.
std::string Presenter::why_no_truth() const {
    if (settings_.layout != gl::DisplayLayout::right && settings_.layout != gl::DisplayLayout::left)
        return "the truth is shown beside one eye (v)";
    // A folder may hold fewer frames than are watched, and one eye of the two: said on the screen, as all of these are.
    if (true_eyes_ == nullptr || true_picture().empty())
        return "there is no truth of this eye at this time";
    const PerspectiveCamera& camera = true_eyes_->camera;
    if (!(inputs_.window == gl::Size{camera.width, camera.height}))
        return formatted("the truth is %dx%d: the window must be", camera.width, camera.height);
    if (std::abs(fov_deg_ - camera.fov_x_rad * 180 / pi) > 1e-6)
        return formatted("the truth is %s degrees wide: the view must be",
                         in_words(camera.fov_x_rad * 180 / pi).c_str());
    if (std::abs(ipd_m() - true_eyes_->ipd_m) > 1e-6)
        return formatted("the truth's eyes are %s m apart: the view's must be", in_words(true_eyes_->ipd_m).c_str());
    if (!same_pose(seen_head_, {}))
        return "the head is not where the truth is (c: back)";
    return "";
}

/// Of the eye that is shown.
const ByteImage& Presenter::true_picture() const {
    return true_eyes_->rgb[settings_.layout == gl::DisplayLayout::right ? 1 : 0];
}

bool Presenter::shows_truth() const {
    return truth_ != nullptr && split_ < 1 && why_no_truth().empty();
}

/// Where the other method would be, and how near what is drawn is to it.
void Presenter::put_truth_beside() {
    const ByteImage& rgb = true_picture();
    other_targets_.size_for(true_eyes_->camera, 1);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTextureSubImage3D(other_targets_.colour(), 0, 0, 0, 0, rgb.width(), rgb.height(), 1, GL_RGB, GL_UNSIGNED_BYTE,
                        rgb.samples().data());
    targets_.download(0, seen_);
    truth_db_ = total_error(squared_errors(seen_.rgb().view(), rgb.view())).psnr_db();
    report_.truth_db = report_.truth_db.value_or(0) + *truth_db_;
    ++truth_count_;
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

ViewerReport Presenter::report() const {
    ViewerReport report = report_;
    report.seconds = now_s_ - began_s_;
    report.latency_s = latency_.seconds();
    report.decode_ms /= double(std::max<std::int64_t>(1, report.frames));
    report.later_s /= double(std::max<std::int64_t>(1, report.refreshes));
    if (playback_.is_live())
        report.playout_delay_s = playback_.playout_delay_s();
    if (report.truth_db)
        *report.truth_db /= double(truth_count_);
    report.decoder = frame().main.decoder;
    if (report.stages_ms)
        for (double& stage_ms : *report.stages_ms)
            stage_ms /= double(std::max<std::int64_t>(1, report.refreshes));
    return report;
}

}  // namespace equistream
