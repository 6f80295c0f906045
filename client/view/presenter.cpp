#include "presenter.h"

#include <client/transport/address.h>
#include <equistream/elapsed.h>
#include <equistream/text.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <thread>
#include <utility>

namespace equistream {

constexpr double zoom_step = 1.1, min_fov_deg = 10, max_fov_deg = 150;
/// Without anything to show; what happens meanwhile ends it.
constexpr double longest_idle_s = 0.5;
/// A refresh that took longer made something for the first time.
constexpr double longest_latency_s = 0.25;
/// Of a display's interval: swaps of one that waits for its refreshes keep the pace by themselves, of others this does.
constexpr double min_interval = 0.9;
/// A head that wears something is never quite at rest.
constexpr double still_m = 0.003;
constexpr double meter_window_s = 2;

Presenter::Presenter(WatchedSource& source, const ShownSettings& shown, const Place& place)
    : source_(source), settings_(source.settings), shown_(shown), truth_(source.truth ? &*source.truth : nullptr),
      fov_deg_(first_fov_deg()), loader_(source.loader), poses_(source.poses), box_(place.box), window_(place.window),
      face_(place.face), headset_(place.headset), playback_(loader_, settings_.paused), renderer_(make_renderer(shown)),
      recorder_(std::make_unique<Recorder>(settings_.out)), began_s_(loader_.now_s()), now_s_(began_s_),
      refreshes_(meter_window_s), frames_(meter_window_s), bits_(meter_window_s) {
    // Not when its first picture comes, which may be in the midst of it all: a shader takes longer than a refresh.
    if (loader_.has_transfer("smpte2084"))
        make_hdr_display();
    advance(now_s_);
}

std::unique_ptr<gl::EyeRenderer> Presenter::make_renderer(const ShownSettings& shown) const {
    const bool by_geometry = settings_.scene && shown.by_geometry;
    auto renderer = std::make_unique<gl::EyeRenderer>(by_geometry ? &*settings_.scene : nullptr,
                                                      head_box_radius(loader_.first()), shown.fill_chain, shown.engine);
    // Until somebody reads there, the buffers stay empty and decoders keep to memory of their own.
    if (settings_.upload == PictureUpload::mapped || !gl::Context::driver().is_software())
        renderer->read_in_place(source_.pictures);
    return renderer;
}

Presenter::~Presenter() = default;

double Presenter::first_fov_deg() const {
    return settings_.fov_deg.value_or(truth_ != nullptr ? truth_->camera().fov_x_rad * 180 / pi : default_view_fov_deg);
}

void Presenter::go_on_from(Presenter& before) {
    motion_.look_as(before.motion_);
    fov_deg_ = before.fov_deg_;
    split_ = before.split_;
    recorder_.swap(before.recorder_);
    if (before.is_paused())
        playback_.pause();
    else
        playback_.play();
    if (!playback_.is_live()) {
        seek(before.wanted_s());
        resumes_ = true;
    } else if (truth_ == nullptr) {  // frames are on their way that were rendered for the head as it is now
        followed_ = before.followed_;
        if (report_.frames > 0)
            followed_.show(frame().main.info.head);
    }
}

void Presenter::know_of(const std::string& loading, const std::vector<std::string>& recent) {
    content_.loading = loading;
    content_.recent = recent;
}

void Presenter::refresh(const ViewInputs& inputs, double longest_rest_s) {
    inputs_ = inputs;
    if (headset_ != nullptr) {
        refresh_headset();
        return;
    }
    take_inputs();
    rest(refresh_window(), longest_rest_s);
}

void Presenter::take_inputs() {
    now_s_ = loader_.now_s();
    for (const Action action : inputs_.pressed)
        act(action);
    steer(now_s_);
}

/// Whether there was anything to draw.
bool Presenter::refresh_window() {
    if (inputs_.window.width == 0 || inputs_.window.height == 0) {
        if (playback_.is_live())
            advance(now_s_);  // what comes is counted
        return false;         // minimised: nobody sees anything
    }
    times_.start(shown_.times);
    const bool is_new = advance(now_s_);
    if (is_resuming())
        return false;
    lead();
    seen_head_ = motion_.predict(settings_.predict_s.value_or(latency_.seconds()));
    extrapolation_s_ = wanted_extrapolation_s(latency_.seconds());
    record_head();
    content_ = make_content();
    Drawn now{seen_head_, extrapolation_s_, face_.is_awake(), content_};
    if (!is_new && !inputs_.any && !picture_wanted_ && !recorder_->records_view() && drawn_ && *drawn_ == now)
        return false;
    draw();
    drawn_ = std::move(now);
    return true;
}

void Presenter::draw() {
    look(inputs_.window);
    ask_for_pixel();
    add_times();
    keep_what_is_asked_for();
    face_.say(content_);
    face_.draw();
    window_.show();
    refreshes_.add(now_s_, 1);
    ++report_.refreshes;
    report_.extrapolation_s += extrapolation_s_;
    if (const double latency_s = loader_.now_s() - now_s_; latency_s < longest_latency_s)
        latency_.measured(latency_s);
}

void Presenter::add_times() {
    const double since_last_s = now_s_ - std::exchange(drawn_s_, now_s_);
    if (!shown_.times)
        return;
    face_.add(times_.row(), 1e3 * since_last_s);
    report_.stages_ms = report_.stages_ms.value_or(gl::StageTimes::Row{});
    for (std::size_t stage = 0; stage < times_.row().size(); ++stage)
        (*report_.stages_ms)[stage] += times_.row()[stage];
}

/// Until the next refresh may have something to draw.
void Presenter::rest(bool drew, double longest_s) {
    if (!drew && !playback_.is_moving() && motion_.is_resting() && !truth_is_coming_ && !probe_.is_waiting()) {
        box_.wait(std::min(longest_s, longest_idle_s));
        return;
    }
    const double left_s = min_interval / window_.refresh_hz() - (loader_.now_s() - now_s_);
    if (left_s > 0)
        std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
}

void Presenter::steer(double now_s) {
    // What the mouse holds in the middle of a picture stays under it.
    const double eye_px = std::max(1, gl::eye_size(shown_.layout, inputs_.window).width);
    const double rad_per_px = 2 * std::tan(fov_deg_ * pi / 360) / eye_px;
    for (const InputSample& sample : inputs_.samples) {
        steering_.drag_yaw_rad = sample.drag_x * rad_per_px;
        steering_.drag_pitch_rad = sample.drag_y * rad_per_px;
        motion_.steer(steering_, loader_.time_s(sample.at));
        steering_ = {.held = sample.held,
                     .turn_x = sample.sticks.turn_x,
                     .turn_y = sample.sticks.turn_y,
                     .move_x = sample.sticks.move_x,
                     .move_y = sample.sticks.move_y,
                     .move_z = sample.sticks.move_z};
    }
    motion_.steer(steering_, now_s);
    fov_deg_ = std::clamp(fov_deg_ * std::pow(zoom_step, -inputs_.scroll), min_fov_deg, max_fov_deg);
    if (inputs_.click_x >= 0 && split_ < 1)
        split_ = float(std::clamp(inputs_.click_x, 0.0, 0.999));
}

/// Whether another frame is shown.
bool Presenter::advance(double now_s) {
    bool is_new = false;
    try {
        if (next_jump_ && !seeking_s_)
            jump(*std::exchange(next_jump_, std::nullopt));
        const Playback::Moment moment = playback_.refresh(now_s);
        if (moment.frame || moment.is_over)
            seeking_s_.reset();
        if (moment.frame) {
            show(moment.frame);
            report_.decode_ms += moment.frame->main.decode_ms;
            if (truth_ == nullptr)
                followed_.show(moment.frame->main.info.head);
            is_new = true;
        }
        if (find_truth())
            is_new = true;
        if (moment.frame) {
            ++report_.frames;
            frames_.add(now_s, 1);
        }
        if (moment.is_over)
            end();
    } catch (const std::exception& error) {
        if (report_.frames == 0)
            throw;
        seeking_s_.reset();
        // What was shown last stays until the next frame; what cannot be read any more has paused itself.
        tell(error.what());
    }
    log_connection();
    const std::int64_t bytes = loader_.figures().bytes;
    bits_.add(now_s, 8.0 * double(bytes - std::exchange(counted_bytes_, bytes)));
    return is_new;
}

/// Until what it goes on from is there, what was shown before stays on the display.
bool Presenter::is_resuming() {
    resumes_ = resumes_ && seeking_s_;
    return resumes_;
}

void Presenter::make_hdr_display() {
    const auto display = settings_.hdr_display ? settings_.hdr_display : std::make_shared<const HdrDisplay>();
    pq_display_ = std::make_shared<gl::PqDisplay>(*display);
    pq_display_->set_exposure(shown_.exposure_stops);
    renderer_->show_pq_by(pq_display_);
}

/// Tracks that do not say that they are HDR may still turn out to be.
void Presenter::show(SharedFrame frame) {
    if (!pq_display_ && gl::has_hdr(*frame))
        make_hdr_display();
    renderer_->show(std::move(frame), times_);
}

void Presenter::end() {
    if (!loader_.truncation().empty())
        tell(loader_.truncation());
    // A picture that is alone is on show already. After a jump past the end none is.
    const bool is_alone = playback_.shown_s() == loader_.first().time_s;
    if (shown_.loop && !is_alone && !playback_.is_paused() && playback_.can_jump())
        playback_.seek(loader_.first().time_s);
    else
        playback_.pause();
}

/// One line when a server is lost, and one when it is there again.
void Presenter::log_connection() {
    const bool is_lost = playback_.attempts() > 0;
    if (is_lost != std::exchange(was_lost_, is_lost))
        std::fprintf(stderr, "%s: %s\n", without_secrets(settings_.source).c_str(),
                     is_lost ? "the connection was lost; trying again" : "connected again");
}

/// A head that only turns leaves the server its own path: a sphere has all directions, but for what is beyond a window.
void Presenter::lead() {
    const bool has_moved =
        is_worn_ ? glm::length(seen_head_.position_m) > still_m : motion_.navigator().offset_m() != glm::dvec3(0);
    const bool steers = has_moved || followed_.is_followed();
    if (!(steers || frame().base) || !poses_.send({frame().main.info.time_s, head(), {}, steers}))
        return;
    if (steers)
        followed_.sent(head());
    else
        followed_.looked(head());
}

ViewerReport Presenter::report() {
    ViewerReport report = report_;
    report.seconds = now_s_ - began_s_;
    report.latency_s = latency_.seconds();
    report.decode_ms /= double(std::max<std::int64_t>(1, report.frames));
    report.extrapolation_s /= double(std::max<std::int64_t>(1, report.refreshes));
    if (playback_.is_live())
        report.playout_delay_s = playback_.playout_delay_s();
    if (report.truth_db)
        *report.truth_db /= double(truth_count_);
    report.decoder = frame().main.decoder;
    report.mapped_bytes = source_.pictures ? source_.pictures->bytes() : 0;
    report.facts = make_facts();
    std::ranges::copy(mouse_facts_, std::back_inserter(report.facts));
    if (report.stages_ms)
        for (double& stage_ms : *report.stages_ms)
            stage_ms /= double(std::max<std::int64_t>(1, report.refreshes));
    return report;
}

}  // namespace equistream
