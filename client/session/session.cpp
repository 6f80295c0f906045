#include "session.h"

#include <client/stages/stages.h>
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
    playback_ = std::make_unique<Playback>(*loader_, settings.paused);
    shown_ = playback_->refresh(loader_->now_s()).frame;
    if (shown_ == nullptr)
        throw WorkError(expected_found(settings.source, "a first frame", "none"));
    choose(ray, gl);
    show(shown_);
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
    cpu_.use({.engine = engine_,
              .by_depth = choice.depth != "none",
              .fill = settings_.fill,
              .mirrors = settings_.mirrors,
              .reliability = settings_.confidence});
    cpu_.use(make_depth(choice.depth, scene_ ? &*scene_ : nullptr, first(), {ray, gl.depth}));
}

bool Session::has_depth() const {
    return find_engine(engine_).needs.any();
}

void Session::show(SharedFrame frame) {
    if (gl_eyes_ != nullptr)
        gl_eyes_->show(frame);
    else if (is_rendered_ && frame != shown_)
        cpu_.remember({shown_, &shown_->main});
    is_rendered_ = false;
    shown_ = std::move(frame);
    shown_time_s_ = shown_->main.info.time_s;
    decode_ms_ += shown_->main.decode_ms;
    ++statistics_.frames_shown;
}

es_pose pose_of(const Pose& pose) {
    const glm::dvec3& p = pose.position_m;
    const glm::dquat& q = pose.orientation;
    return {{p.x, p.y, p.z}, {q.w, q.x, q.y, q.z}};
}

SessionState Session::advance(double display_s) {
    SessionState state{};
    try {
        Playback::Moment moment = playback_->refresh(display_s);
        if (moment.frame) {
            show(std::move(moment.frame));
            state.is_new = true;
            is_over_ = false;
        }
        if (moment.is_over) {
            is_over_ = true;
            if (settings_.loop && !playback_->is_live() && !playback_->is_paused())
                playback_->seek(first().time_s);
        }
    } catch (const std::exception& problem) {
        state.problem = problem.what();
        playback_->pause();
    }
    state.frame = shown_->main.info.index;
    state.time_s = playback_->time_s();
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
    double across = 0, down = 0;
    for (const SessionEye& eye : request.eyes) {
        across = std::max(across, std::tan(eye.fov.right_rad) - std::tan(eye.fov.left_rad));
        down = std::max(down, std::tan(eye.fov.up_rad) - std::tan(eye.fov.down_rad));
    }
    // As many columns as fit, of the left eye's field of view: the limit of rows counts too.
    const double left = std::tan(request.eyes[0].fov.right_rad) - std::tan(request.eyes[0].fov.left_rad);
    const double focal_px = std::min(request.width / across, request.height / down);
    pictures_.view = covering_view({request.eyes[0].fov, request.eyes[1].fov},
                                   std::max(1, int(std::floor(focal_px * left + 1e-6))), max_covering_view);
    std::array<EyeView, 2> eyes;
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        eyes[i] = {pictures_.view.camera, composed(request.head, request.eyes[i].in_head)};
        state.is_outside_box =
            state.is_outside_box || (shown_->posed && leaves_head_box(eyes[i].pose, shown_->main.info));
    }
    return eyes;
}

double Session::wanted_extrapolation_s() const {
    return settings_.max_extrapolation_s > 0 ? playback_->extrapolation_s(settings_.max_extrapolation_s) : 0;
}

void Session::render_cpu(const std::array<EyeView, 2>& views, SessionState& state) {
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
    state.extrapolation_s = gl_eyes_->can_extrapolate() ? wanted_extrapolation_s() : 0;
    gl_eyes_->render(views, state.extrapolation_s);
}

SessionState Session::render(const SessionRequest& request, const SessionPictures*& pictures) {
    SessionState state = advance(request.display_s);
    const auto start = Clock::now();
    const std::array<EyeView, 2> views = set_views(request, state);
    if (gl_eyes_ == nullptr) {
        render_cpu(views, state);
    } else {
        render_gl(views, state);
        for (int i = 0; i < 2; ++i) {
            PipelineEye& eye = pictures_.eyes[std::size_t(i)];
            eye.camera = views[std::size_t(i)].camera;
            gl_eyes_->download(i, eye.picture, eye.depth_m);
        }
    }
    render_ms_ += milliseconds_since(start);
    ++statistics_.pictures_rendered;
    judge();
    pictures = &pictures_;
    return state;
}

SessionState Session::draw(const SessionRequest& request, CoveringView& view) {
    SessionState state = advance(request.display_s);
    const auto start = Clock::now();
    render_gl(set_views(request, state), state);
    view = pictures_.view;
    render_ms_ += milliseconds_since(start);
    ++statistics_.pictures_rendered;
    return state;
}

void Session::judge() {
    double confidence = 0, not_seen = 0, pixels = 0;
    for (const PipelineEye& eye : pictures_.eyes) {
        const auto origins = eye.picture.origin.samples();
        const auto samples = eye.picture.reliability.samples();
        pixels += double(origins.size());
        not_seen += double(origins.size()) - double(eye.picture.count(PixelOrigin::source));
        confidence += std::accumulate(samples.begin(), samples.end(), 0.0) / 255;
    }
    statistics_.gaps = not_seen / pixels;
    statistics_.mean_confidence = settings_.confidence ? confidence / pixels : 0;
}

void Session::seek(double time_s) {
    if (is_live())
        throw InputError(expected_found("time_s", "a recorded source", "a live one, which comes as it comes"));
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
    return all;
}

}  // namespace equistream
