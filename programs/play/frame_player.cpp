#include "frame_player.h"

#include <client/depth/gl/gl_depth.h>
#include <client/depth/ray_colour.h>
#include <client/depth/ray_depth.h>
#include <client/stages/stages.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/stream.h>
#include <equistream/text.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <utility>

namespace equistream::play {

namespace {

std::unique_ptr<DepthSource> ray_depth(const SceneDescription& scene) {
    return std::make_unique<RayDepth>(scene);
}

DrawnDepth drawn_depth(const SceneDescription& scene, bool cube, double box_radius_m) {
    auto drawn = std::make_unique<GlDepth>(scene, GlDepthOptions{.cube = cube, .box_radius_m = box_radius_m});
    std::string driver = drawn->driver();
    return {std::move(drawn), std::move(driver)};
}

constexpr GeometryModules geometry_modules{.ray = {.depth = ray_depth}, .drawn = drawn_depth};

/// The same frame without what is true of its coded picture alone: an eye's picture is coded anew.
FrameInfo without_coding(FrameInfo info) {
    info.depth_code.reset();
    info.crf.reset();
    info.visible_loss.reset();
    info.moving.clear();
    return info;
}

}  // namespace

FramePlayer::FramePlayer(const Settings& settings) : settings_(settings) {
    if (!settings.head.empty())
        head_path_ = read_path_csv(settings.head);
    if (!settings.scene.empty())
        scene_ = load_scene(settings.scene);
    if (settings.scene_is_model && scene_->stands_for.empty())
        throw InputError(expected_found(settings.scene.string(), "a client's model, as equistream model writes it",
                                        "a scene (--scene takes those)"));
}

FramePlayer::~FramePlayer() = default;

void FramePlayer::prepare(const ReceivedFrame& first, Report& report) {
    if (scene_ && first.posed)
        if (auto note = require_same_scene(first.main.info, settings_.source, *scene_, settings_.scene.string()))
            report.notes.push_back(std::move(*note));
    check_size(first);
    if (const std::string note = clock_note(head_path_, settings_.head); !note.empty())
        report.notes.push_back(note);
    const DepthOffer offered = offer(first);
    DepthChoice choice =
        choose_depth({.source = settings_.source, .method = settings_.method, .depth = settings_.depth}, offered);
    std::ranges::move(choice.notes, std::back_inserter(report.notes));
    report.depth = choice.depth;
    report.method = choice.method;
    make_geometry();
    Plan plan{.method = choice.method, .depth = choice.depth, .fill = settings_.fill};
    if (plan.method == "auto")  // until it is settled
        plan.method = scene_ ? "eye-depth" : choice.depth != "none" ? "mesh" : "rotation";
    use(plan);
    if (scene_ && !scene_->stands_for.empty() && pipeline_.fill().has("geometry"))
        report.notes.push_back("--fill geometry is ignored: " + settings_.scene.string() +
                               ", a client's model, has no colours (pass the scene itself as --scene)");
    MadeDepth made = make_depth(choice.depth, scene_ ? &*scene_ : nullptr, first.main.info, geometry_modules);
    report.gl_driver = made.driver;
    report.scene_load_ms = made.load_ms;
    gives_depth_ = made.source != nullptr;
    pipeline_.use(std::move(made));
}

DepthOffer FramePlayer::offer(const ReceivedFrame& first) const {
    std::error_code ignored;
    DepthOffer offered{.scene = scene_.has_value(),
                       .folder = std::filesystem::is_directory(settings_.source, ignored),
                       .posed = first.posed,
                       .plane = !first.main.depth_m.empty(),
                       .eye_without_plane = eye_without_plane(first)};
    if (first.main.info.depth_code)
        offered.code = first.main.info.depth_code->code;
    return offered;
}

std::optional<Eye> FramePlayer::eye_without_plane(const ReceivedFrame& first) const {
    const auto by_eye = make_engine("eye-depth");
    for (const Eye eye : {Eye::left, Eye::right}) {
        const FrameInfo view = eye_info(first, eye);
        const auto is_view = [&](const ReceivedPicture& other) {
            return !other.depth_m.empty() && same_camera(other.info.camera, view.camera) &&
                   same_pose(other.info.camera_pose, view.camera_pose);
        };
        if (by_eye->needs_depth(first.main.info.camera_pose, view.camera_pose).eye && !is_view(first.main) &&
            std::ranges::none_of(first.depth_views, is_view))
            return eye;
    }
    return std::nullopt;
}

void FramePlayer::make_geometry() {
    // A client's model has no colours to fill from.
    if (!scene_ || !scene_->stands_for.empty() || !has_pass(make_fill_chain(settings_.fill), "geometry"))
        return;
    auto geometry = std::make_unique<RayColour>(*scene_);
    geometry->start_loading();  // while the first frame is decoded and its depth cast
    pipeline_.use(std::move(geometry));
}

void FramePlayer::check_size(const ReceivedFrame& first) const {
    const PerspectiveCamera eye = eye_camera(first.main.info);
    if (settings_.format == Format::mp4 &&
        (eye.width % 2 != 0 || eye.height % 2 != 0 || eye.width < min_track_side || eye.height < min_track_side))
        throw InputError(
            expected_found("--size", "even sides of at least " + std::to_string(min_track_side) + " for --format mp4",
                           std::to_string(eye.width) + "x" + std::to_string(eye.height)));
}

PerspectiveCamera FramePlayer::eye_camera(const FrameInfo& source) const {
    PerspectiveCamera camera{default_size.width, default_size.height, default_fov_deg * pi / 180};
    if (const auto* perspective = std::get_if<PerspectiveCamera>(&source.camera))
        camera = *perspective;
    if (settings_.size) {
        camera.width = settings_.size->width;
        camera.height = settings_.size->height;
    }
    if (settings_.fov_deg)
        camera.fov_x_rad = *settings_.fov_deg * pi / 180;
    return camera;
}

FrameInfo FramePlayer::eye_info(const ReceivedFrame& frame, Eye eye, const RefreshMoment* refresh) const {
    FrameInfo info = without_coding(frame.main.info);
    info.camera = eye_camera(frame.main.info);
    info.eye = eye;
    info.lock = AxisLock::path;
    if (settings_.ipd_m)
        info.ipd_m = *settings_.ipd_m;
    if (refresh != nullptr) {
        if (refresh->number < 0 || refresh->number > max_frame_index)
            throw InputError(expected_found(
                formatted("--refresh: frame %lld", static_cast<long long>(frame.main.info.index)),
                formatted("a display time from 0 to %.0f s", double(max_frame_index) / refresh->refresh_hz),
                formatted("%g s", refresh->display_s)));
        info.index = refresh->number;
        info.time_s = refresh->display_s;
        info.frames_per_second = refresh->refresh_hz;
        info.head = refresh->head;
    } else if (!head_path_.empty()) {
        info.head = head_path_.at(info.time_s);
    }
    info.camera_pose = camera_pose(info.camera, info.head, eye, info.ipd_m, AxisLock::path);
    return info;
}

void FramePlayer::set_eyes(const ReceivedFrame& frame, PlayedFrame& played, const RefreshMoment* refresh) const {
    for (const auto& [eye, which] : {std::pair{&played.left, Eye::left}, {&played.right, Eye::right}}) {
        eye->info = eye_info(frame, which, refresh);
        eye->camera = std::get<PerspectiveCamera>(eye->info.camera);
        eye->pose = eye->info.camera_pose;
    }
}

std::array<double, 2> FramePlayer::decoding_ms(const ReceivedFrame& frame) const {
    std::array ms = {frame.main.decode_ms, frame.main.convert_ms};
    for (const auto& [role, other] : {std::pair{TrackRole::main, &frame.base},
                                      {TrackRole::small, &frame.small},
                                      {TrackRole::hidden, &frame.hidden},
                                      {TrackRole::patches, &frame.patches}})
        if (*other && !uncounted_[std::size_t(role)]) {
            ms[0] += (*other)->decode_ms;
            ms[1] += (*other)->convert_ms;
        }
    return ms;
}

/// Eyes of a frame whose depth is lost turn in it and do not move, as in ordinary video. Geometry replaces any depth.
void FramePlayer::choose_ways_of(const ReceivedFrame& frame) {
    const bool lacks = plan_.depth != "none" && !scene_ && frame.main.depth_m.empty();
    if (std::exchange(lacks_depth_, lacks) != lacks)
        pipeline_.use(ways());
}

void FramePlayer::play(const ReceivedFrame& frame, PlayedFrame& played, const RefreshMoment* refresh) {
    choose_ways_of(frame);
    set_eyes(frame, played, refresh);
    FrameFigures& figures = played.figures;
    figures = {};
    figures.index = played.left.info.index;
    figures.time_s = played.left.info.time_s;
    figures.has_small = frame.small.has_value();
    figures.lacks_depth = lacks_depth_;
    figures.outside_head_box = frame.posed && (leaves_head_box(played.left.pose, frame.main.info) ||
                                               leaves_head_box(played.right.pose, frame.main.info));
    if (refresh != nullptr)
        figures.extrapolation_s =
            pipeline_.extrapolation_s(frame, played.left, played.right, refresh->extrapolation_s, scene_.has_value());
    StageTimes& times = figures.milliseconds;
    const auto [decode_ms, convert_ms] = decoding_ms(frame);
    times[std::size_t(Stage::decode)] = {decode_ms};
    times[std::size_t(Stage::convert)] = {convert_ms};
    played.times.clear();
    for (int i = 0; i < settings_.repeat; ++i) {
        PipelineTimes pipeline;
        pipeline_.render(frame, played.left, played.right, figures.extrapolation_s, pipeline);
        if (takes_depth())
            times[std::size_t(Stage::depth)].push_back(pipeline.depth);
        times[std::size_t(Stage::reproject)].push_back(pipeline.reproject);
        times[std::size_t(Stage::fill)].push_back(pipeline.fill);
        if (settings_.reliability)
            times[std::size_t(Stage::reliability)].push_back(pipeline.reliability);
        const double after_depth_ms = pipeline.reproject + pipeline.reliability;
        played.times.push_back({.all = decode_ms + convert_ms + pipeline.depth + after_depth_ms + pipeline.fill,
                                .unfilled = frame.main.decode_ms + frame.main.convert_ms + pipeline.depth -
                                            pipeline.fill_depth + after_depth_ms});
    }
    figures.moved_pixels = pipeline_.moved_pixels();
    figures.uncovered_pixels = pipeline_.uncovered_pixels();
    figures.left = played.left.figures;
    figures.right = played.right.figures;
}

void FramePlayer::remember(ReceivedFrame&& frame) {
    pipeline_.remember(std::make_shared<const ReceivedPicture>(std::move(frame.main)),
                       frame.base ? std::make_shared<const ReceivedPicture>(std::move(*frame.base)) : nullptr);
}

}  // namespace equistream::play
