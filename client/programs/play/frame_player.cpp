#include "frame_player.h"

#include "view_writer.h"

#include <equistream/bound.h>
#include <equistream/depth_code.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/stream.h>
#include <equistream_client/ray_depth.h>
#include <equistream_client/reliability.h>

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace equistream::play {

namespace {

/// The head box around a source's centre (bound.h).
double box_radius_m(const FrameInfo& info) {
    return head_box_radius(info.eye, info.lean_m, info.ipd_m);
}

/// Beyond rounding of poses that lie on the ball, as an eye at rest does.
bool leaves_head_box(const FrameInfo& eye, const FrameInfo& source) {
    return glm::distance(eye.camera_pose.position_m, source.camera_pose.position_m) > box_radius_m(source) + 1e-6;
}

/// What the depth in use may be off by, in w: nothing where it is cast or the renderer's own.
double depth_tolerance_w(bool streamed, const FrameInfo& source) {
    if (!streamed || !source.depth_code)
        return 0;
    return std::sin(quantisation_bound_rad(*make_depth_code(source.depth_code->code), source.depth_code->range));
}

void require_tagged_size(const ReceivedPicture& picture, const std::string& source) {
    if (picture.width() != width_of(picture.info.camera) || picture.height() != height_of(picture.info.camera))
        throw WorkError(expected_found(source + ": frame " + std::to_string(picture.info.index),
                                       std::to_string(width_of(picture.info.camera)) + "x" +
                                           std::to_string(height_of(picture.info.camera)) + " as its tag says",
                                       std::to_string(picture.width()) + "x" + std::to_string(picture.height())));
}

/// Whose depth a method cannot do without once the eye moves.
DepthNeeds needs_when_moved(const Engine& engine) {
    return engine.needs_depth(Pose{}, Pose{{1, 0, 0}, {1, 0, 0, 0}});
}

/// Calls work(eye, figures) for both, side by side: what one thread does of an eye, another does of the other
/// meanwhile.
template <typename Work>
void for_both_eyes(PlayedFrame& played, const Work& work) {
    tbb::parallel_invoke([&] { work(played.left, played.figures.left); },
                         [&] { work(played.right, played.figures.right); });
}

}  // namespace

FramePlayer::FramePlayer(const Settings& settings, Report& report) : settings_(settings) {
    if (!settings.head.empty())
        head_path_ = read_path_csv(settings.head);
    if (!settings.scene.empty())
        scene_ = load_scene(settings.scene);
    if (settings.scene_is_model && scene_->stands_for.empty())
        throw InputError(expected_found(settings.scene.string(), "a client's model, as equistream model writes it",
                                        "a scene (--scene takes those)"));
    choose_method(report);
    make_depth_source(report);
    use_fill(settings.fill);
}

FramePlayer::~FramePlayer() = default;

void FramePlayer::choose_method(Report& report) {
    const bool streamed = settings_.depth == "stream";
    const bool has_depth = scene_ || settings_.depth == "exact" || streamed;
    report.method = settings_.method;
    if (report.method.empty() && !has_depth)
        report.notes.push_back("no scene, so no depth: method sphere (rotation only); --scene S gives parallax, and "
                               "--depth stream where the stream has a depth track");
    if (report.method.empty())
        report.method = !has_depth ? "sphere" : streamed && !scene_ ? "gather" : "surface";
    if (report.method == "auto")  // until the first frame shows what there is
        report.method = scene_ ? "surface" : has_depth ? "mesh" : "sphere";
    method_ = report.method;
    engine_ = make_engine(method_);
    if (needs_when_moved(*engine_).any() && !has_depth)
        throw InputError(expected_found("--method " + method_,
                                        "--scene S, --depth stream or --depth exact, to have depth", "none of them"));
    if (needs_when_moved(*engine_).eye && streamed && !scene_)
        throw InputError(expected_found("--method " + method_,
                                        "--scene S, for the eyes' own depth, which no stream has (gather, mesh and "
                                        "splat need none)",
                                        "--depth stream alone"));
}

void FramePlayer::settle(const ReceivedFrame& first, Report& report) {
    report.fill = settings_.fill;
    if (settings_.method != "auto")
        return;
    if (exact_ == nullptr && !first.main.depth_m.empty()) {
        auto exact = std::make_unique<ExactDepth>(std::move(depth_));
        exact_ = exact.get();
        depth_ = std::move(exact);
    }
    const int repeat = std::exchange(settings_.repeat, 3);
    const auto measure = [&](const Plan& plan) {
        use(plan);
        PlayedFrame played;
        play(first, played);
        // The first round warms up; of the others the slower one counts.
        double ms = 0;
        for (const std::vector<double>& stage : played.figures.milliseconds)
            if (!stage.empty())
                ms += *std::max_element(stage.size() > 1 ? stage.begin() + 1 : stage.begin(), stage.end());
        return ms;
    };
    const std::vector<Plan> plans = plans_by_accuracy({.geometry = scene_.has_value(),
                                                       .streamed_depth = exact_ != nullptr,
                                                       .poses = first.posed,
                                                       .fill = settings_.fill});
    report.choice = choose_plan(plans, settings_.budget_ms, measure);
    settings_.repeat = repeat;
    const Plan& plan = report.choice->tried[report.choice->chosen].plan;
    use(plan);
    report.method = plan.method;
    report.depth = plan.depth;
    report.fill = plan.fill;
}

void FramePlayer::use(const Plan& plan) {
    method_ = plan.method;
    engine_ = make_engine(plan.method, {.mesh_share = plan.mesh_share});
    use_fill(plan.fill);
    offers_depth_ = plan.depth == "stream";
}

bool FramePlayer::takes_streamed_depth() const {
    return settings_.method == "auto" ? exact_ != nullptr && offers_depth_ : settings_.depth == "stream";
}

void FramePlayer::use_fill(const std::string& rungs) {
    std::unique_ptr<FrameFill>& fill = fills_[rungs];
    if (!fill)
        fill = std::make_unique<FrameFill>(rungs, scene_ ? &*scene_ : nullptr);
    fill_ = fill.get();
}

void FramePlayer::make_depth_source(Report& report) {
    report.depth = "none";
    if (!needs_when_moved(*engine_).any())
        return;
    report.depth = settings_.depth;
    std::unique_ptr<DepthSource> ray;
    if (scene_) {
        const auto start = Clock::now();
        ray = std::make_unique<RayDepth>(*scene_);
        report.scene_load_ms = milliseconds_since(start);
    }
    if (settings_.depth == "ray") {
        depth_ = std::move(ray);
        return;
    }
    auto exact = settings_.depth == "stream" ? std::make_unique<StreamDepth>(std::move(ray))
                                             : std::make_unique<ExactDepth>(std::move(ray));
    exact_ = exact.get();
    depth_ = std::move(exact);
}

void FramePlayer::check(const ReceivedFrame& first, Report& report) {
    if (!first.posed && method_ != "sphere" && settings_.method != "auto")
        throw InputError(expected_found(settings_.source, "pictures tagged with their pose, for --method " + method_,
                                        "ordinary video (--method sphere turns it)"));
    if (scene_ && first.posed)
        check_scene(first.main.info, report);
    if (exact_ != nullptr && settings_.depth == "stream" && first.main.depth_m.empty())
        throw InputError(expected_found("--depth stream", "a stream with a depth track (encode --depth auto)",
                                        "none in " + settings_.source));
    if (exact_ != nullptr && first.main.depth_m.empty())
        throw InputError(
            expected_found("--depth exact", "a folder of rendered frames with their depth", settings_.source));
    if (exact_ != nullptr && !scene_)
        check_exact_depth(first);
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

void FramePlayer::check_exact_depth(const ReceivedFrame& first) {
    offer_exact_depth(first);
    for (const Eye eye : {Eye::left, Eye::right}) {
        const FrameInfo view = eye_info(first, eye);
        if (engine_->needs_depth(first.main.info.camera_pose, view.camera_pose).eye &&
            !exact_->holds(view.camera, view.camera_pose))
            throw InputError(expected_found("--depth exact",
                                            "--scene S, or a rendered depth plane of this very " +
                                                std::string(eye == Eye::left ? "left" : "right") +
                                                " eye's view beside " + settings_.source,
                                            "neither"));
    }
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

FrameInfo FramePlayer::eye_info(const ReceivedFrame& frame, Eye eye) const {
    FrameInfo info = frame.main.info;
    info.camera = eye_camera(frame.main.info);
    info.eye = eye;
    info.lock = AxisLock::path;
    if (settings_.ipd_m)
        info.ipd_m = *settings_.ipd_m;
    if (!head_path_.empty())
        info.head = head_path_.at(info.time_s);
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
    for (PlayedEye* eye : {&played.left, &played.right}) {
        const DepthNeeds own = engine_->needs_depth(frame.main.info.camera_pose, eye->info.camera_pose);
        if (own.eye)
            cast(eye->info.camera, eye->info.camera_pose, eye->depth_m);
        else
            eye->depth_m = {};
        needs = {needs.source || own.source, needs.eye || own.eye};
    }
    if (!needs.any())
        return;
    if (needs.source) {
        cast(frame.main.info.camera, frame.main.info.camera_pose, depths.main);
        depths_.main = std::move(depths.main);
    }
    const bool small_has_depth =
        frame.small &&
        (exact_ == nullptr || scene_ || exact_->holds(frame.small->info.camera, frame.small->info.camera_pose));
    if (small_has_depth && fill_->has("small")) {
        cast(frame.small->info.camera, frame.small->info.camera_pose, depths.small);
        depths_.small = std::move(depths.small);
    }
    if (frame.patches && fill_->has("patches")) {
        cast_patches(*frame.patches, depths.patches);
        depths_.patches = std::move(depths.patches);
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
    if (!depth_->cast_patches(*atlas, patches.info.camera_pose, depth_m.view()))
        depth_m = {};
}

void FramePlayer::reproject_and_fill(const ReceivedFrame& frame, const SourceDepths& depths, PlayedFrame& played) {
    auto start = Clock::now();
    const SourceView source = source_view(frame.main, depths.main);
    engine_->set_source(source);
    for_both_eyes(played, [&](PlayedEye& eye, EyeFigures& figures) {
        engine_->reproject(eye.view(), eye.picture);
        figures = {};
        figures.specular = rework_specular(source, eye.view(), EngineOptions{}.error_budget_px, eye.picture);
    });
    played.figures.milliseconds[std::size_t(Stage::reproject)].push_back(milliseconds_since(start));

    for_both_eyes(played, [](PlayedEye& eye, EyeFigures& figures) {
        find_gap_mask(eye.picture, eye.gaps);
        figures.pixels = std::int64_t(eye.gaps.samples().size());
        figures.gaps = eye.picture.count(PixelOrigin::gap);
    });

    start = Clock::now();
    fill_->set_frame(frame, depths);
    for_both_eyes(played,
                  [&](PlayedEye& eye, EyeFigures& figures) { figures.filled = fill_->fill(eye.view(), eye.picture); });
    played.figures.milliseconds[std::size_t(Stage::fill)].push_back(milliseconds_since(start));
    if (!settings_.reliability)
        return;
    start = Clock::now();
    for (auto [eye, figures] :
         {std::pair{&played.left, &played.figures.left}, {&played.right, &played.figures.right}}) {
        estimate_reliability(source, eye->view(), eye->picture,
                             {.depth_tolerance_w = depth_tolerance_w(takes_streamed_depth(), frame.main.info),
                              .specular_reworked = true});
        const auto samples = eye->picture.reliability.samples();
        figures->reliability = std::accumulate(samples.begin(), samples.end(), 0.0) / (255.0 * double(samples.size()));
    }
    played.figures.milliseconds[std::size_t(Stage::reliability)].push_back(milliseconds_since(start));
}

void FramePlayer::play(const ReceivedFrame& frame, PlayedFrame& played) {
    require_tagged_size(frame.main, settings_.source);
    if (frame.small)
        require_tagged_size(*frame.small, settings_.source);
    played.left.info = eye_info(frame, Eye::left);
    played.right.info = eye_info(frame, Eye::right);
    played.figures = {};
    played.figures.index = frame.main.info.index;
    played.figures.time_s = frame.main.info.time_s;
    played.figures.has_small = frame.small.has_value();
    played.figures.outside_head_box = frame.posed && (leaves_head_box(played.left.info, frame.main.info) ||
                                                      leaves_head_box(played.right.info, frame.main.info));
    StageTimes& times = played.figures.milliseconds;
    double decode_ms = frame.main.decode_ms, convert_ms = frame.main.convert_ms;
    for (const auto* other : {&frame.small, &frame.hidden, &frame.patches})
        if (*other) {
            decode_ms += (*other)->decode_ms;
            convert_ms += (*other)->convert_ms;
        }
    times[std::size_t(Stage::decode)] = {decode_ms};
    times[std::size_t(Stage::convert)] = {convert_ms};
    for (int i = 0; i < settings_.repeat; ++i) {
        const auto start = Clock::now();
        if (depth_)
            depth_->set_time(frame.main.info.time_s);
        if (exact_ != nullptr && offers_depth_)
            offer_exact_depth(frame);
        cast_depths(frame, played);
        if (depth_)
            times[std::size_t(Stage::depth)].push_back(milliseconds_since(start));
        reproject_and_fill(frame, depths_, played);
    }
}

void FramePlayer::remember(ReceivedFrame&& frame) {
    fill_->remember(std::move(frame), depths_);
}

}  // namespace equistream::play
