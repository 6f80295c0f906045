#pragma once
/// Frames with all that gaps may be filled from, the scene they are of as triangles, and what the CPU makes of them.
#include "gl_fixture.h"

#include <equistream/window.h>

#include <client/confidence/reliability.h>
#include <client/depth/gl/gl_depth.h>
#include <client/depth/ray_colour.h>
#include <client/extrapolate/extrapolate.h>
#include <client/fill/fill.h>
#include <client/receive/receive.h>
#include <client/reflections/specular.h>
#include <client/warp/engine.h>
#include <tests/unit/client/fill_scene.h>
#include <tests/unit/evidence.h>
#include <tests/unit/scenes/generate/scratch_folder.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace equistream::test {

inline ReceivedPicture picture_of(const Rendered& rendered) {
    ReceivedPicture picture;
    picture.info.camera = rendered.camera;
    picture.info.camera_pose = picture.info.head = rendered.pose;
    picture.rgb = rendered.rgb;
    return picture;
}

/// High up on the wall, where no gaps are; what is in it lies a metre behind.
inline void hang_mirror(const Rendered& rendered, ReceivedPicture& picture) {
    picture.specular = picture.virtual_depth_m = FloatImage(rendered.depth_m.width(), rendered.depth_m.height(), 1);
    for (int y = 0; y < picture.specular.height(); ++y)
        for (int x = 0; x < picture.specular.width(); ++x) {
            const glm::dvec3 d = direction_of(rendered.camera, x + 0.5, y + 0.5);
            const float r = *rendered.depth_m.pixel(x, y);
            *picture.specular.pixel(x, y) = r * d.y > 1.1 && r < 10 ? 1.0f : 0.0f;
            *picture.virtual_depth_m.pixel(x, y) = r + 1;
        }
}

/// Where a centimetre a frame along X leads; everything there is to fill gaps from comes with it.
inline std::shared_ptr<const ReceivedFrame> make_frame(std::int64_t index, const Camera& camera,
                                                       bool with_depth = false) {
    const Pose pose{{-0.0315 - 0.01 * double(index), 0, 0}, {1, 0, 0, 0}};
    auto frame = std::make_shared<ReceivedFrame>();
    const Rendered main = render(ball_and_wall, red_and_smooth, camera, pose);
    frame->main = picture_of(main);
    if (with_depth)
        frame->main.depth_m = main.depth_m;
    hang_mirror(main, frame->main);
    Rendered hidden = render(wall_alone, red_and_smooth, camera, pose);
    for (std::size_t i = 0; i < hidden.depth_m.samples().size(); ++i)
        if (hidden.depth_m.samples()[i] == main.depth_m.samples()[i])
            hidden.depth_m.samples()[i] = std::nanf("");
    // Not all of what is behind: other fill passes are to have work too.
    for (int y = 0; y < hidden.depth_m.height() / 2; ++y)
        for (int x = 0; x < hidden.depth_m.width(); ++x)
            *hidden.depth_m.pixel(x, y) = std::nanf("");
    frame->hidden = picture_of(hidden);
    frame->hidden->depth_m = std::move(hidden.depth_m);
    Patches patches;
    patches.render_from(pose);
    frame->patches.emplace();
    frame->patches->info.camera_pose = pose;
    frame->patches->info.camera = EquirectCamera{patches.atlas.width(), patches.atlas.height(), {}};
    frame->patches->info.patches = patches.atlas;
    frame->patches->rgb = std::move(patches.rgb);
    frame->patches->depth_m = std::move(patches.depth_m);
    frame->small = picture_of(render(ball_and_wall, red_and_smooth, PerspectiveCamera{160, 100, pi / 2},
                                     {pose.position_m + glm::dvec3(0.063, 0, 0), pose.orientation}));
    for (ReceivedPicture* picture : {&frame->main, &*frame->hidden, &*frame->small, &*frame->patches}) {
        picture->info.index = index;
        picture->info.time_s = double(index) / 30;
    }
    return frame;
}

/// Whose depth comes with a frame.
enum class Streamed { nothing, window_depth, all_depth };

/// A window of the sphere that leads along X, so many blocks from the middle, as dense as eyes are, within a coarse one
/// of less contrast; nothing else comes with it. A mirror hangs across its border. Without a window a coarse one alone.
inline std::shared_ptr<const ReceivedFrame> make_window_frame(std::int64_t index, std::optional<int> blocks_right,
                                                              Streamed streamed) {
    constexpr WindowGrid grid{1024, 512, 208, 160};
    const Pose pose{{-0.0315 - 0.01 * double(index), 0, 0}, {1, 0, 0, 0}};
    const auto picture = [&](const Camera& camera, double contrast, bool with_depth) {
        const auto colour = [&](const glm::dvec3& p, double) { return 0.5 + contrast * (smooth(p, 1.5) - 0.5); };
        const Rendered rendered = render(ball_and_wall, colour, camera, pose);
        ReceivedPicture made = picture_of(rendered);
        if (with_depth)
            made.depth_m = rendered.depth_m;
        if (contrast == 1)
            hang_mirror(rendered, made);
        made.info.index = index;
        made.info.time_s = double(index) / 30;
        return made;
    };
    auto frame = std::make_shared<ReceivedFrame>();
    Camera main = EquirectCamera{512, 256, {}};
    if (blocks_right) {
        frame->base = picture(main, 0.6, streamed == Streamed::all_depth);
        WindowPlace place = window_around(grid, {0, 0, -1});
        place.x += *blocks_right * window_block_px;
        main = window_camera(grid, place);
    }
    frame->main = picture(main, 1, streamed != Streamed::nothing);
    return frame;
}

inline constexpr glm::dvec3 ball_m_s(2.4, 0.6, 0);

enum class Mirror { none, wall, ball };

/// The ball on its way, painted, before the wall; the frame says how it moves. The head stands still. Mirrors: none, a
/// part of the wall that the ball comes before, or the ball.
inline std::shared_ptr<const ReceivedFrame> make_moving_frame(std::int64_t index, const Camera& camera,
                                                              Mirror mirror = Mirror::none, bool with_depth = false) {
    const double time_s = double(index) / 30;
    const glm::dvec3 centre_m = glm::dvec3(0, 0, -1.2) + time_s * ball_m_s;
    const auto ball = [&](const glm::dvec3& o, const glm::dvec3& d) { return to_sphere(o, d, centre_m, 0.3); };
    const Pose pose;
    auto frame = std::make_shared<ReceivedFrame>();
    const Rendered main =
        render([&](const auto& o, const auto& d) { return std::min(ball(o, d), wall_alone(o, d)); },
               [&](const glm::dvec3& p, double) {
                   return glm::length(p - centre_m) < 0.31 ? 1.0 - smooth(p - centre_m, 12) : smooth(p, 1.5);
               },
               camera, pose);
    frame->main = picture_of(main);
    if (with_depth)
        frame->main.depth_m = main.depth_m;
    FrameInfo& info = frame->main.info;
    info.index = index;
    info.time_s = time_s;
    MovingRegion region{{{ball_m_s, {}}, {}}, 0.8f, 2.0f, {}};
    for (int y = 0; y < main.depth_m.height(); ++y)
        for (int x = 0; x < main.depth_m.width(); ++x) {
            const glm::dvec3 d = direction_of(camera, x + 0.5, y + 0.5);
            if (!(ball(pose.position_m, d) < infinity))
                continue;
            if (!region.runs.empty() && region.runs.back().row == y && region.runs.back().end == x)
                ++region.runs.back().end;
            else
                region.runs.push_back({y, x, x + 1});
        }
    info.moving = {region};
    if (mirror != Mirror::none) {
        frame->main.specular = frame->main.virtual_depth_m = FloatImage(width_of(camera), height_of(camera), 1);
        for (int y = 0; y < main.depth_m.height(); ++y)
            for (int x = 0; x < main.depth_m.width(); ++x) {
                const glm::dvec3 d = direction_of(camera, x + 0.5, y + 0.5);
                const bool on_ball = ball(pose.position_m, d) < infinity;
                const bool in_frame = d.z < 0 && std::abs(d.x / d.z + 0.35) < 0.25 && std::abs(d.y / d.z) < 0.35;
                *frame->main.specular.pixel(x, y) =
                    (mirror == Mirror::ball ? on_ball : in_frame && !on_ball) ? 1.0f : 0.0f;
                *frame->main.virtual_depth_m.pixel(x, y) = *main.depth_m.pixel(x, y) + 1;
            }
    }
    // What it uncovers: push-pull would spread a single pixel of its outline over all of that.
    Rendered wall = render(
        wall_alone, [](const glm::dvec3& p, double) { return smooth(p, 1.5); }, camera, pose);
    frame->hidden = picture_of(wall);
    frame->hidden->depth_m = std::move(wall.depth_m);
    frame->hidden->info.index = index;
    frame->hidden->info.time_s = time_s;
    return frame;
}

class GlEyeRenderer : public Gl {
protected:
    static void SetUpTestSuite() {
        Gl::SetUpTestSuite();
        folder = std::make_unique<ScratchFolder>("eye-renderer");
        scene.file = scene.model = folder->path() / "ball.obj";
        write_model(scene.model);
        moving_scene = scene;
        moving_scene.moving = {{"ball", PosePath({{0, {}}, {1, {ball_m_s, {1, 0, 0, 0}}}}, "ball")}};
    }
    static void TearDownTestSuite() {
        folder.reset();
        Gl::TearDownTestSuite();
    }

    static std::array<EyeView, 2> eyes_at(const Pose& head) {
        const PerspectiveCamera camera{320, 200, pi / 2};
        return {EyeView{camera, {head.position_m + head.orientation * glm::dvec3(-0.0315, 0, 0), head.orientation}},
                EyeView{camera, {head.position_m + head.orientation * glm::dvec3(0.0315, 0, 0), head.orientation}}};
    }

    static inline std::unique_ptr<ScratchFolder> folder;
    static inline SceneDescription scene, moving_scene;
    const PerspectiveCamera flat{400, 250, 2 * std::atan(1.25)};
};

/// As `play` does it: with a scene by --depth gl, without by the frame's depth.
class OnTheCpu {
public:
    OnTheCpu(const SceneDescription* scene, double box_radius_m, const std::string& passes,
             const std::string& finding_engine = "mesh")
        : passes_(passes), engine_(scene != nullptr ? "surface" : finding_engine) {
        if (scene != nullptr && passes.find("geometry") != std::string::npos)
            colours_.emplace(*scene);
        if (scene != nullptr)
            depth_.emplace(*scene, GlDepthOptions{.box_radius_m = box_radius_m});
    }

    /// `extrapolation_s`: extrapolated by so much. `left`: a frame whose window the gaze has left; null: there is none.
    EyePicture see(const ReceivedFrame& frame, const ReceivedFrame& before, EyeView eye, double extrapolation_s = 0,
                   const ReceivedFrame* left = nullptr) {
        const FloatImage before_m = depth_of(before.main);
        FloatImage eye_m;
        if (depth_) {
            depth_->set_time(frame.main.info.time_s + extrapolation_s);
            eye_m = cast(eye.camera, eye.pose);
            eye.depth_m = eye_m.view();
        }
        const FloatImage main_m = depth_of(frame.main);
        ExtrapolatedPicture extrapolated;
        if (extrapolation_s > 0)
            PictureExtrapolator().extrapolate(frame.main, main_m, extrapolation_s, extrapolated);
        const SourceView main = extrapolation_s > 0 ? source_view(extrapolated.picture, extrapolated.depth_m)
                                                    : source_view(frame.main, main_m);
        std::vector<SourceView> earlier = {source_view(before.main, before_m)}, earlier_bases(1);
        const FloatImage left_m = left != nullptr ? depth_of(left->main) : FloatImage();
        if (left != nullptr) {
            earlier.push_back(source_view(left->main, left_m));
            earlier_bases.push_back(source_view(*left->base, {}));
        }
        std::optional<SourceView> base, hidden, small;
        FloatImage base_m;
        BaseEngine base_engine(engine_, {});
        if (frame.base) {
            base_m = depth_of(*frame.base);
            base = source_view(*frame.base, base_m);
            base_engine.set_base(*base);
        }
        if (frame.hidden)
            hidden = source_view(*frame.hidden, frame.hidden->depth_m);
        FloatImage small_m;
        if (frame.small) {
            if (depth_)
                small_m = depth_of(*frame.small);
            small = source_view(*frame.small, small_m);
        }
        std::optional<PatchesView> patches;
        if (frame.patches)
            patches = PatchesView{.rgb = frame.patches->rgb.view(),
                                  .depth_m = frame.patches->depth_m.view(),
                                  .atlas = &*frame.patches->info.patches,
                                  .pose = frame.patches->info.camera_pose,
                                  .box_radius_m = main.box_radius_m};
        const auto engine = make_engine(engine_);
        engine->set_source(main);
        EyePicture picture;
        engine->reproject(eye, picture);
        const SpecularCounts counts = rework_specular(main, eye, picture, {.treatment = mirrors});
        mirrored += mirrors == MirrorTreatment::gaps ? counts.gaps : counts.by_image;
        const FillChain chain = make_fill_chain(passes_);
        if (colours_)
            colours_->set_time(frame.main.info.time_s + extrapolation_s);
        for (const auto& fill_pass : chain)
            fill_pass->set_frame({.main = &main,
                                  .small = small ? &*small : nullptr,
                                  .base = base ? &*base : nullptr,
                                  .base_engine = &base_engine,
                                  .earlier = earlier,
                                  .earlier_bases = earlier_bases,
                                  .hidden = hidden ? &*hidden : nullptr,
                                  .patches = patches ? &*patches : nullptr,
                                  .geometry = colours_ ? &*colours_ : nullptr});
        fill_gaps(chain, eye, picture);
        estimate_reliability(main, eye, picture, {.specular_reworked = true});
        return picture;
    }

    MirrorTreatment mirrors = MirrorTreatment::images;
    std::int64_t mirrored = 0;  ///< pixels that were looked up by images, or made gaps

private:
    FloatImage depth_of(const ReceivedPicture& picture) {
        if (!depth_)
            return picture.depth_m;
        depth_->set_time(picture.info.time_s);
        return cast(picture.info.camera, picture.info.camera_pose);
    }
    FloatImage cast(const Camera& camera, const Pose& pose) {
        FloatImage depth_m(width_of(camera), height_of(camera), 1);
        depth_->cast(camera, pose, depth_m.view());
        return depth_m;
    }

    std::string passes_, engine_;
    std::optional<GlDepth> depth_;
    std::optional<RayColour> colours_;
};

inline double psnr_db(const ByteImage& a, const ByteImage& b) {
    double squares = 0;
    for (std::size_t i = 0; i < a.samples().size(); ++i)
        squares += std::pow(double(a.samples()[i]) - double(b.samples()[i]), 2);
    return 10 * std::log10(255.0 * 255 * double(a.samples().size()) / std::max(squares, 1e-9));
}

/// Within which two pictures are the same.
struct Limits {
    double min_db = 50, other_reliabilities = 0.01, other_origins = 0.002;
};

/// Where fill passes with nothing but the picture itself have much to fill, a single pixel of an outline that fell on
/// its other side, as they do, is spread over that, and all of it is as far from what was seen as that pixel is.
inline constexpr Limits large_fills{.min_db = 45, .other_reliabilities = 0.03};

/// Origins far enough apart to be told by eye.
inline ByteImage spread_out(ByteImage origins) {
    constexpr int step = 255 / (pixel_origin_count - 1);
    for (std::uint8_t& origin : origins.samples())
        origin = std::uint8_t(step * origin);
    return origins;
}

/// Of a refresh's two pictures.
inline void expect_same(const EyePicture& found, const EyePicture& expected, const Limits& limits) {
    EXPECT_GT(psnr_db(found.rgba, expected.rgba), limits.min_db) << evidence(found.rgb().view(), expected.rgb().view());
    EXPECT_EQ(found.count(PixelOrigin::gap), 0);
    const double pixels = double(found.origin.samples().size());
    int other_origins = 0, other_reliabilities = 0;
    for (std::size_t p = 0; p < found.origin.samples().size(); ++p) {
        other_origins += found.origin.samples()[p] != expected.origin.samples()[p];
        other_reliabilities += std::abs(found.reliability.samples()[p] - expected.reliability.samples()[p]) > 2;
    }
    EXPECT_LT(other_origins, limits.other_origins * pixels)
        << evidence(spread_out(found.origin).view(), spread_out(expected.origin).view());
    EXPECT_LT(other_reliabilities, limits.other_reliabilities * pixels)
        << evidence(found.reliability.view(), expected.reliability.view());
}

}  // namespace equistream::test
