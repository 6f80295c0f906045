#include "session.h"

#include <client/stages/stages.h>
#include <client/transport/address.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <utility>

namespace equistream {

namespace {

/// As client.h says of es_client_open.
constexpr double first_frame_limit_s = 60;

std::shared_ptr<const HdrDisplay> display_of(double exposure_stops) {
    HdrDisplaySettings settings;
    settings.exposure_stops = exposure_stops;
    return std::make_shared<const HdrDisplay>(settings);
}

/// Before the first frame says what there is: whatever any engine may use.
PipelineChoice widest_choice(const SessionSettings& settings) {
    return {.engine = settings.engine.empty() ? "eye-depth" : settings.engine,
            .depth = settings.scene.empty() ? "stream" : "ray",
            .fill = settings.fill,
            .mirrors = settings.mirrors != MirrorTreatment::surface || settings.confidence};
}

DepthOffer offer_of(const SessionSettings& settings, const ReceivedFrame& first) {
    std::error_code ignored;
    DepthOffer offer{.scene = !settings.scene.empty(),
                     .folder = std::filesystem::is_directory(settings.source, ignored),
                     .posed = first.posed,
                     .plane = !first.main.depth_m.empty(),
                     .code = std::nullopt,
                     .eye_without_plane = Eye::left};  // eyes may look from anywhere
    if (first.main.info.depth_code)
        offer.code = first.main.info.depth_code->code;
    return offer;
}

}  // namespace

Session::Session(const SessionSettings& settings, const RayModule& ray, const GlModule& gl) : settings_(settings) {
    const bool by_gl = gl.eyes != nullptr;
    check_stages(by_gl);
    if (!settings.scene.empty())
        scene_ = load_scene(settings.scene);
    FeedOptions options;
    options.depth = true;
    options.hardware = settings.hardware;
    options.yuv = true;
    options.pq = by_gl;
    if (settings.exposure_stops != 0)
        options.hdr_display = display_of(settings.exposure_stops);
    options.specular = settings.mirrors != MirrorTreatment::surface || settings.confidence;
    options.left_out = [unused = unneeded_roles(widest_choice(settings_))] { return unused; };
    options.poses = &poses_;
    options.first_frame_limit_s = first_frame_limit_s;
    loader_ = std::make_unique<FrameLoader>(settings.source, std::move(options));
    settings_.source = without_secrets(settings.source);
    playback_ = std::make_unique<Playback>(*loader_, settings.paused);
    display_s_ = loader_->now_s();
    shown_ = playback_->refresh(display_s_).frame;
    if (shown_ == nullptr)
        throw WorkError(expected_found(settings_.source, "a first frame", "none"));
    choose(ray, gl);
    show(shown_);
    count_shown();
    rendered_ = shown_;
    playback_->hold();  // a scene and shaders take their time, and so may the caller: the first frame is seen first
}

Session::~Session() = default;

void Session::check_stages(bool by_gl) {
    if (!settings_.engine.empty()) {
        const EngineStage& engine = find_engine(settings_.engine, "engine");
        if (by_gl)
            require_on_gpu(engine, "engine");
        settings_.engine = engine.name;
    }
    for (const FillStage* pass : parse_fills(settings_.fill, "fill"))
        if (by_gl)
            require_on_gpu(*pass, "fill");
}

void Session::choose(const RayModule& ray, const GlModule& gl) {
    if (scene_ && shown_->posed)
        require_same_scene(first(), settings_.source, *scene_, settings_.scene);
    const DepthOffer offer = offer_of(settings_, *shown_);
    const DepthChoice choice = choose_depth({.source = settings_.source,
                                             .method = settings_.engine,
                                             .depth = "",
                                             .method_option = "engine",
                                             .scene_option = "a scene",
                                             .depth_option = ""},
                                            offer);
    engine_ = choice.method;
    if (gl.eyes != nullptr) {
        gl_eyes_ = gl.eyes({.scene = scene_ ? &*scene_ : nullptr,
                            .box_radius_m = head_box_radius(first()),
                            .engine = engine_,
                            .fill = settings_.fill,
                            .mirrors = settings_.mirrors,
                            .confidence = settings_.confidence,
                            .by_depth = choice.depth != "none" || find_engine(engine_).finds_depth,
                            .exposure_stops = settings_.exposure_stops});
        return;
    }
    if (scene_ && scene_->stands_for.empty() && ray.colour != nullptr &&
        std::ranges::count(parse_fills(settings_.fill), &find_fill("geometry")) > 0)
        cpu_.use(ray.colour(*scene_));
    by_depth_ = choice.depth != "none";
    cpu_.use(ways());
    cpu_.use(make_depth(choice.depth, scene_ ? &*scene_ : nullptr, first(), {ray, gl.depth}));
}

PipelineWays Session::ways() const {
    return {.engine = lacks_depth_ ? "rotation" : engine_,
            .by_depth = by_depth_ && !lacks_depth_,
            .fill = settings_.fill,
            .mirrors = settings_.mirrors,
            .reliability = settings_.confidence};
}

bool Session::has_depth() const {
    return find_engine(engine_).needs.any();
}

/// Where this throws, the frame before stays.
void Session::show(SharedFrame frame) {
    if (gl_eyes_ != nullptr)
        gl_eyes_->show(frame);
    else if (is_rendered_ && frame != shown_)
        cpu_.remember({shown_, &shown_->main}, {shown_, shown_->base ? &*shown_->base : nullptr});
    is_rendered_ = false;
    shown_ = std::move(frame);
    shown_time_s_ = shown_->main.info.time_s;
}

void Session::count_shown() {
    decode_ms_ += shown_->main.decode_ms;
    for (const auto* beside : {&shown_->base, &shown_->small, &shown_->hidden, &shown_->patches})
        decode_ms_ += *beside ? (*beside)->decode_ms : 0;
    ++statistics_.frames_shown;
}

es_pose pose_of(const Pose& pose) {
    const glm::dvec3& p = pose.position_m;
    const glm::dquat& q = pose.orientation;
    return {{p.x, p.y, p.z}, {q.w, q.x, q.y, q.z}};
}

bool Session::begins_anew() const {
    return settings_.loop && playback_->can_jump() && !playback_->is_paused();
}

/// Shows what is due. Returns why that cannot be; empty: it can.
std::string Session::advance(double display_s) {
    display_s_ = std::max(display_s_, display_s);
    try {
        Playback::Moment moment = playback_->refresh(display_s_);
        if (moment.is_over && begins_anew())
            playback_->seek(first().time_s);
        else
            is_over_ = moment.is_over || (is_over_ && !moment.frame);
        if (moment.frame)
            show(std::move(moment.frame));
    } catch (const std::exception& problem) {
        return problem.what();
    }
    return {};
}

SessionState Session::shown_state() const {
    SessionState state{};
    state.frame = shown_->main.info.index;
    // After a jump what was shown stays until the frame that was sought is there.
    state.time_s = playback_->shown_s() ? playback_->time_s() : shown_->main.info.time_s;
    state.head = pose_of(shown_->main.info.head);
    state.fraction_done = playback_->fraction_done();
    state.overdue_s = playback_->overdue_s();
    state.playout_delay_s = is_live() ? playback_->playout_delay_s() : 0;
    state.is_over = is_over_;
    state.is_paused = playback_->is_paused();
    state.is_lost = playback_->attempts() > 0;
    return state;
}

std::array<EyeView, 2> Session::set_views(const SessionRequest& request, SessionState& state) {
    view_ = fitted_view({request.eyes[0].fov, request.eyes[1].fov}, {request.width, request.height}, max_covering_view);
    poses_.look_through(view_.camera);
    std::array<EyeView, 2> eyes;
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        eyes[i] = {view_.camera, composed(request.head, request.eyes[i].in_head)};
        state.is_outside_box =
            state.is_outside_box || (shown_->posed && leaves_head_box(eyes[i].pose, shown_->main.info));
    }
    return eyes;
}

double Session::wanted_extrapolation_s() const {
    // Where the frame that was given last cannot be shown, an earlier one stands for it.
    const double frame_s = shown_->main.info.time_s;
    const double before_s = std::max(0.0, playback_->shown_s().value_or(frame_s) - frame_s);
    return std::min(settings_.max_extrapolation_s,
                    playback_->extrapolation_s(settings_.max_extrapolation_s) + before_s);
}

/// Eyes of a frame whose depth is lost turn in it and do not move, as in ordinary video.
void Session::choose_ways_of_frame() {
    const bool lacks = find_engine(engine_).needs.any() && !scene_ && shown_->main.depth_m.empty();
    if (std::exchange(lacks_depth_, lacks) != lacks)
        cpu_.use(ways());
}

void Session::render_cpu(const std::array<EyeView, 2>& views, SessionState& state) {
    choose_ways_of_frame();
    PipelineEye &left = pictures_.eyes[0], &right = pictures_.eyes[1];
    for (std::size_t i = 0; i < views.size(); ++i) {
        pictures_.eyes[i].camera = views[i].camera;
        pictures_.eyes[i].pose = views[i].pose;
    }
    state.extrapolation_s = cpu_.extrapolation_s(*shown_, left, right, wanted_extrapolation_s(), scene_.has_value());
    PipelineTimes times;
    cpu_.render(*shown_, left, right, state.extrapolation_s, times);
    is_rendered_ = true;
}

void Session::render_gl(const std::array<EyeView, 2>& views, SessionState& state) {
    state.extrapolation_s = gl_eyes_->render(views, wanted_extrapolation_s());
}

SessionState Session::render_shown(const SessionRequest& request) {
    SessionState state = shown_state();
    const std::array<EyeView, 2> views = set_views(request, state);
    if (gl_eyes_ != nullptr)
        render_gl(views, state);
    else
        render_cpu(views, state);
    return state;
}

/// Of what is due, or where that fails of the frame before. Where both fail, what is due is tried again next time.
SessionState Session::render_due(const SessionRequest& request) {
    std::string problem = advance(request.display_s);
    const auto start = Clock::now();
    SessionState state;
    try {
        state = render_shown(request);
    } catch (const std::exception& failure) {
        if (shown_ == rendered_)
            throw;
        problem = failure.what();
        const SharedFrame due = shown_;
        show(rendered_);
        try {
            state = render_shown(request);
        } catch (...) {
            show(due);
            throw;
        }
    }
    state.problem = std::move(problem);
    state.is_new = std::exchange(rendered_, shown_) != shown_;
    if (state.is_new)
        count_shown();
    render_ms_ += milliseconds_since(start);
    ++statistics_.pictures_rendered;
    return state;
}

SessionState Session::render(const SessionRequest& request) {
    pictures_.view = {};
    SessionState state = render_due(request);
    if (gl_eyes_ != nullptr)
        download();
    pictures_.view = view_;
    return state;
}

void Session::download() {
    const auto start = Clock::now();
    for (int i = 0; i < 2; ++i) {
        PipelineEye& eye = pictures_.eyes[std::size_t(i)];
        eye.camera = view_.camera;
        gl_eyes_->download(i, eye.picture, eye.depth_m);
    }
    render_ms_ += milliseconds_since(start);
}

/// What was handed out of the last pictures in memory.
void Session::judge(es_client_statistics& all) const {
    std::int64_t pixels = 0, seen = 0, trusted = 0;
    for (std::size_t i = 0; i < pictures_.eyes.size(); ++i) {
        const ViewPart& part = pictures_.view.parts[i];
        const EyePicture& picture = pictures_.eyes[i].picture;
        pixels += std::int64_t{part.width} * part.height;
        for (int y = part.top; y < part.top + part.height; ++y) {
            const std::uint8_t* origins = picture.origin.pixel(part.left, y);
            seen += std::count(origins, origins + part.width, std::uint8_t(PixelOrigin::source));
            if (!settings_.confidence)
                continue;
            const std::uint8_t* samples = picture.reliability.pixel(part.left, y);
            trusted = std::accumulate(samples, samples + part.width, trusted);
        }
    }
    if (pixels == 0)
        return;
    all.gaps = double(pixels - seen) / double(pixels);
    all.mean_confidence = double(trusted) / (255.0 * double(pixels));
}

void Session::play() {
    is_over_ = false;
    playback_->play();
}

void Session::seek(double time_s) {
    if (is_live())
        throw InputError(expected_found("time_s", "a recorded source", "a live one, which comes as it comes"));
    if (!playback_->can_jump())
        throw InputError(expected_found("time_s", "a source that can be read again", "a pipe"));
    is_over_ = false;
    playback_->seek(time_s);
}

bool Session::send_head(const Pose& head) {
    return poses_.send({shown_time_s_, head});
}

es_client_statistics Session::statistics() const {
    es_client_statistics all = statistics_;
    const LoaderFigures received = loader_->figures();
    all.frames_received = received.frames;
    all.bytes_received = received.bytes;
    all.reconnections = received.reconnections;
    all.decode_ms = decode_ms_ / double(std::max<std::int64_t>(1, all.frames_shown));
    all.render_ms = render_ms_ / double(std::max<std::int64_t>(1, all.pictures_rendered));
    judge(all);
    return all;
}

}  // namespace equistream
