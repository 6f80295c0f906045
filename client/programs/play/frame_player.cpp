#include "frame_player.h"

#include "view_writer.h"

#include <equistream/depth_code.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/stream.h>
#include <equistream_client/gl_depth.h>
#include <equistream_client/ray_colour.h>
#include <equistream_client/received_view.h>
#include <equistream_client/reliability.h>

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numeric>
#include <utility>

namespace equistream::play {

namespace {

/// Beyond rounding of poses that lie on the ball, as an eye at rest does.
bool leaves_head_box(const FrameInfo& eye, const FrameInfo& source) {
    return glm::distance(eye.camera_pose.position_m, source.camera_pose.position_m) > head_box_radius(source) + 1e-6;
}

void require_tagged_size(const ReceivedPicture& picture, const std::string& source) {
    if (picture.width() != width_of(picture.info.camera) || picture.height() != height_of(picture.info.camera))
        throw WorkError(expected_found(source + ": frame " + std::to_string(picture.info.index),
                                       std::to_string(width_of(picture.info.camera)) + "x" +
                                           std::to_string(height_of(picture.info.camera)) + " as its tag says",
                                       std::to_string(picture.width()) + "x" + std::to_string(picture.height())));
}

/// The same frame without what is true of its coded picture alone: an eye's picture is coded anew.
FrameInfo without_coding(FrameInfo info) {
    info.depth_code.reset();
    info.crf.reset();
    info.coding_loss.reset();
    info.moving.clear();
    return info;
}

/// Calls work(eye, figures) for both, side by side: what one thread does of an eye, another does of the other
/// meanwhile.
template <typename Work>
void for_both_eyes(PlayedFrame& played, const Work& work) {
    tbb::parallel_invoke([&] { work(played.left, played.figures.left); },
                         [&] { work(played.right, played.figures.right); });
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
        check_scene(first.main.info, report);
    check_size(first);
    if (const std::string note = clock_note(head_path_, settings_.head); !note.empty())
        report.notes.push_back(note);
    const DepthOffer offered = offer(first);
    DepthChoice choice = choose_depth(settings_, offered);
    std::ranges::move(choice.notes, std::back_inserter(report.notes));
    report.depth = choice.depth;
    report.method = choice.method;
    plan_ = {.method = choice.method, .depth = choice.depth, .fill = settings_.fill};
    if (plan_.method == "auto")  // until it is settled
        plan_.method = scene_ ? "eye-depth" : choice.depth != "none" ? "mesh" : "rotation";
    engine_ = make_engine(plan_.method);
    make_geometry();
    use_fill(plan_.fill);
    if (scene_ && !scene_->stands_for.empty() && fill_->has("geometry"))
        report.notes.push_back("--fill geometry is passed over: " + settings_.scene.string() +
                               ", a client's model, has no colours (--scene S of the scene itself has)");
    make_depth_source(first.main.info, choice.depth, report);
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
    if (!scene_ || !scene_->stands_for.empty() || !has_rung(make_fill_ladder(settings_.fill), "geometry"))
        return;
    auto geometry = std::make_unique<RayColour>(*scene_);
    geometry->start_loading();  // while the first frame is decoded and its depth cast
    geometry_ = std::move(geometry);
}

void FramePlayer::use_fill(const std::string& rungs) {
    std::unique_ptr<FrameFill>& fill = fills_[rungs];
    if (!fill)
        fill = std::make_unique<FrameFill>(rungs, geometry_.get());
    fill_ = fill.get();
}

void FramePlayer::make_depth_source(const FrameInfo& first, const std::string& depth, Report& report) {
    if (depth == "none")
        return;
    if (is_drawn(depth)) {
        const auto start = Clock::now();
        auto drawn = std::make_unique<GlDepth>(
            *scene_, GlDepthOptions{.cube = depth == "gl-cube", .box_radius_m = head_box_radius(first)});
        report.gl_driver = drawn->driver();
        depth_ = std::move(drawn);
        report.scene_load_ms = milliseconds_since(start);
        return;
    }
    std::unique_ptr<RayDepth> ray;
    if (scene_) {
        const auto start = Clock::now();
        ray = std::make_unique<RayDepth>(*scene_);
        report.scene_load_ms = milliseconds_since(start);
    }
    if (depth == "ray") {
        depth_ = std::move(ray);
        return;
    }
    auto exact = depth == "stream" ? std::make_unique<StreamDepth>(std::move(ray))
                                   : std::make_unique<ExactDepth>(std::move(ray));
    exact_ = exact.get();
    depth_ = std::move(exact);
}

void FramePlayer::check_size(const ReceivedFrame& first) const {
    const PerspectiveCamera eye = eye_camera(first.main.info);
    if (settings_.format == Format::mp4 &&
        (eye.width % 2 != 0 || eye.height % 2 != 0 || eye.width < min_track_side || eye.height < min_track_side))
        throw InputError(
            expected_found("--size", "even sides of at least " + std::to_string(min_track_side) + " for --format mp4",
                           std::to_string(eye.width) + "x" + std::to_string(eye.height)));
}

void FramePlayer::check_scene(const FrameInfo& first, Report& report) const {
    const auto require_same = [&](const std::string& what, const std::string& rendered, const std::string& here) {
        if (rendered != here)
            throw InputError(
                expected_found(settings_.scene.string(),
                               "the " + what + " '" + rendered + "' that " + settings_.source + " was rendered from",
                               "'" + here + "'"));
    };
    require_same("scene", first.scene, scene_->name);
    if (first.geometry_fingerprint.empty())
        report.notes.push_back(settings_.source + " does not name its geometry: that of " + settings_.scene.string() +
                               " is taken for it");
    else
        require_same("geometry", first.geometry_fingerprint, scene_->depth_of_geometry());
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

void FramePlayer::offer_exact_depth(const ReceivedFrame& frame) {
    const auto offer = [&](const ReceivedPicture& picture) {
        if (!picture.depth_m.empty())
            exact_->add(picture.info.camera, picture.info.camera_pose, picture.depth_m);
    };
    offer(frame.main);
    if (frame.small)
        offer(*frame.small);
    for (const ReceivedPicture& view : frame.depth_views)
        offer(view);
}

void FramePlayer::cast_depths(const ReceivedFrame& frame, PlayedFrame& played) {
    SourceDepths depths = std::exchange(depths_, {});
    if (!depth_)
        return;
    const auto cast = [&](const Camera& camera, const Pose& pose, FloatImage& depth_m) {
        if (depth_m.width() != width_of(camera) || depth_m.height() != height_of(camera))
            depth_m = FloatImage(width_of(camera), height_of(camera), 1);
        depth_->cast(camera, pose, depth_m.view());
    };
    DepthNeeds needs;
    const double later_s = played.figures.moved_on_s;
    if (later_s > 0)
        depth_->set_time(frame.main.info.time_s + later_s);
    for (PlayedEye* eye : {&played.left, &played.right}) {
        const DepthNeeds own = engine_->needs_depth(frame.main.info.camera_pose, eye->info.camera_pose);
        if (own.eye)
            cast(eye->info.camera, eye->info.camera_pose, eye->depth_m);
        else
            eye->depth_m = {};
        needs = {needs.source || own.source, needs.eye || own.eye};
    }
    if (later_s > 0)
        set_frame_time(frame);
    if (!needs.any())
        return;
    if (needs.source) {
        cast(frame.main.info.camera, frame.main.info.camera_pose, depths.main);
        depths_.main = std::move(depths.main);
    }
    const bool small_has_depth =
        frame.small &&
        (exact_ == nullptr || scene_ || exact_->holds(frame.small->info.camera, frame.small->info.camera_pose));
    if (small_has_depth && fill_->takes_small()) {
        const auto start = Clock::now();
        cast(frame.small->info.camera, frame.small->info.camera_pose, depths.small);
        depths_.small = std::move(depths.small);
        add_cast("small", milliseconds_since(start));
    }
    if (frame.patches && fill_->has("patches")) {
        const auto start = Clock::now();
        cast_patches(*frame.patches, depths.patches);
        depths_.patches = std::move(depths.patches);
        add_cast("patches", milliseconds_since(start));
    }
}

void FramePlayer::cast_patches(const ReceivedPicture& patches, FloatImage& depth_m) {
    const auto& atlas = patches.info.patches;
    if (!patches.depth_m.empty() || !atlas || patch_atlas_problem(*atlas)) {
        depth_m = {};
        return;
    }
    if (depth_m.width() != atlas->width() || depth_m.height() != atlas->height())
        depth_m = FloatImage(atlas->width(), atlas->height(), 1);
    if (depth_->cast_patches(*atlas, patches.info.camera_pose, depth_m.view()))
        return;
    depth_m = {};
    missed_patch_depth_ = is_drawn(plan_.depth);
}

void FramePlayer::reproject_and_fill(const ReceivedFrame& frame, const SourceDepths& depths, PlayedFrame& played) {
    auto start = Clock::now();
    const SourceView source = main_view(frame, played);
    engine_->set_source(source);
    for_both_eyes(played, [&](PlayedEye& eye, EyeFigures& figures) {
        engine_->reproject(eye.view(), eye.picture);
        figures = {};
        figures.specular = rework_specular(source, eye.view(), eye.picture, {.treatment = settings_.mirrors});
    });
    parts_[part::reproject(plan_)] = milliseconds_since(start);
    played.figures.milliseconds[std::size_t(Stage::reproject)].push_back(parts_[part::reproject(plan_)]);

    for_both_eyes(played, [](PlayedEye& eye, EyeFigures& figures) {
        find_gap_mask(eye.picture, eye.gaps);
        figures.pixels = std::int64_t(eye.gaps.samples().size());
        figures.gaps = eye.picture.count(PixelOrigin::gap);
    });

    start = Clock::now();
    fill_->set_frame(frame, depths, {source, frame.main.info.time_s + played.figures.moved_on_s});
    std::vector<double> left_ms(fill_->names().size()), right_ms(left_ms);
    for_both_eyes(played, [&](PlayedEye& eye, EyeFigures& figures) {
        figures.filled = fill_->fill(eye.view(), eye.picture, &eye == &played.left ? left_ms : right_ms);
    });
    const double fill_ms = milliseconds_since(start);
    add_filling(left_ms, right_ms, fill_ms);
    played.figures.milliseconds[std::size_t(Stage::fill)].push_back(fill_ms);
    if (!settings_.reliability)
        return;
    start = Clock::now();
    for (auto [eye, figures] :
         {std::pair{&played.left, &played.figures.left}, {&played.right, &played.figures.right}}) {
        estimate_reliability(source, eye->view(), eye->picture,
                             {.depth_tolerance_w = takes_planes() ? depth_tolerance_w(frame.main.info.depth_code) : 0,
                              .coding_loss = coding_loss_of(frame.main.info),
                              .specular_reworked = settings_.mirrors != MirrorTreatment::surface});
        const auto samples = eye->picture.reliability.samples();
        figures->reliability = std::accumulate(samples.begin(), samples.end(), 0.0) / (255.0 * double(samples.size()));
    }
    parts_[part::reliability()] = milliseconds_since(start);
    played.figures.milliseconds[std::size_t(Stage::reliability)].push_back(parts_[part::reliability()]);
}

void FramePlayer::play(const ReceivedFrame& frame, PlayedFrame& played, const RefreshMoment* refresh) {
    require_tagged_size(frame.main, settings_.source);
    if (frame.small)
        require_tagged_size(*frame.small, settings_.source);
    played.left.info = eye_info(frame, Eye::left, refresh);
    played.right.info = eye_info(frame, Eye::right, refresh);
    played.figures = {};
    played.figures.index = played.left.info.index;
    played.figures.time_s = played.left.info.time_s;
    played.figures.has_small = frame.small.has_value();
    played.figures.outside_head_box = frame.posed && (leaves_head_box(played.left.info, frame.main.info) ||
                                                      leaves_head_box(played.right.info, frame.main.info));
    played.figures.moved_on_s = carried_s(frame, played, refresh);
    StageTimes& times = played.figures.milliseconds;
    double decode_ms = frame.main.decode_ms, convert_ms = frame.main.convert_ms;
    for (const auto* other : {&frame.small, &frame.hidden, &frame.patches})
        if (*other) {
            decode_ms += (*other)->decode_ms;
            convert_ms += (*other)->convert_ms;
        }
    times[std::size_t(Stage::decode)] = {decode_ms};
    times[std::size_t(Stage::convert)] = {convert_ms};
    played.parts.clear();
    for (int i = 0; i < settings_.repeat; ++i) {
        parts_ = parts_with_decoding(frame);
        const auto start = Clock::now();
        take_depths(frame, played);
        const double depth_ms = milliseconds_since(start);
        if (takes_depth()) {
            times[std::size_t(Stage::depth)].push_back(depth_ms);
            parts_[part::depth(plan_)] += depth_ms;  // less what add_cast took
        }
        reproject_and_fill(frame, depths_, played);
        played.parts.push_back(std::move(parts_));
    }
}

double FramePlayer::carried_s(const ReceivedFrame& frame, const PlayedFrame& played,
                              const RefreshMoment* refresh) const {
    if (refresh == nullptr || !can_carry_on(frame.main, refresh->moved_on_s) || !takes_depth())
        return 0;
    for (const PlayedEye* eye : {&played.left, &played.right}) {
        const DepthNeeds needs = engine_->needs_depth(frame.main.info.camera_pose, eye->info.camera_pose);
        // Without geometry eyes have depth of the frame's own time alone.
        if (!needs.source || (needs.eye && !scene_))
            return 0;
    }
    return refresh->moved_on_s;
}

void FramePlayer::set_frame_time(const ReceivedFrame& frame) {
    depth_->set_time(frame.main.info.time_s);
    if (takes_planes())
        offer_exact_depth(frame);
}

void FramePlayer::take_depths(const ReceivedFrame& frame, PlayedFrame& played) {
    if (takes_depth())
        set_frame_time(frame);
    cast_depths(frame, played);
    FrameFigures& figures = played.figures;
    if (figures.moved_on_s == 0)
        return;
    carrier_.carry_on(frame.main, depths_.main, figures.moved_on_s, carried_);
    figures.moved_pixels = carried_.moved_pixels;
    figures.uncovered_pixels = carried_.uncovered_pixels;
}

SourceView FramePlayer::main_view(const ReceivedFrame& frame, const PlayedFrame& played) const {
    return played.figures.moved_on_s > 0 ? source_view(carried_.picture, carried_.depth_m)
                                         : source_view(frame.main, depths_.main);
}

void FramePlayer::remember(ReceivedFrame&& frame) {
    fill_->remember(std::move(frame), depths_);
}

}  // namespace equistream::play
