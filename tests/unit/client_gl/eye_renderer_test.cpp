/// A whole refresh of the viewer: held to what the CPU makes of the same frame, and without anything being made, on the
/// GPU or in memory, once everything was drawn.
#include "counted_memory.h"
#include "gl_fixture.h"
#include "made_objects.h"
#include "patches_scene.h"
#include "scratch_folder.h"

#include <view/gl/eye_renderer.h>

#include <equistream/error.h>
#include <equistream_client/carry_on.h>
#include <equistream_client/gl_depth.h>
#include <equistream_client/received_view.h>
#include <equistream_client/reliability.h>
#include <equistream_client/specular.h>

#include <array>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace equistream::test {
namespace {

/// The ball and the wall of fill_scene.h as triangles.
void write_model(const std::filesystem::path& file) {
    std::ofstream obj(file);
    obj << "o ball\n";
    constexpr int steps = 90;
    for (int j = 0; j <= steps; ++j)
        for (int i = 0; i <= 2 * steps; ++i) {
            const double longitude = pi * i / steps, latitude = pi * j / steps;
            obj << "v " << 0.3 * std::sin(latitude) * std::cos(longitude) << ' ' << 0.3 * std::cos(latitude) << ' '
                << -1.2 + 0.3 * std::sin(latitude) * std::sin(longitude) << '\n';
        }
    for (int j = 0; j < steps; ++j)
        for (int i = 0; i < 2 * steps; ++i) {
            const int row = 2 * steps + 1, a = 1 + j * row + i;
            obj << "f " << a << ' ' << a + 1 << ' ' << a + row + 1 << ' ' << a + row << '\n';
        }
    obj << "o wall\nv -60 -60 -3\nv 60 -60 -3\nv 60 60 -3\nv -60 60 -3\nf -4 -3 -2 -1\n";
}

ReceivedPicture picture_of(const Rendered& rendered) {
    ReceivedPicture picture;
    picture.info.camera = rendered.camera;
    picture.info.camera_pose = picture.info.head = rendered.pose;
    picture.rgb = rendered.rgb;
    return picture;
}

/// High up on the wall, where no gaps are; what is in it lies a metre behind.
void hang_mirror(const Rendered& rendered, ReceivedPicture& picture) {
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
std::shared_ptr<const ReceivedFrame> make_frame(std::int64_t index, const Camera& camera, bool with_depth = false) {
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
    // Not all of what is behind: other rungs are to have work too.
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

constexpr glm::dvec3 ball_m_s(2.4, 0.6, 0);

/// The ball on its way, painted, before the wall; the frame says how it moves. The head stands still.
std::shared_ptr<const ReceivedFrame> make_moving_frame(std::int64_t index, const Camera& camera) {
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
    OnTheCpu(const SceneDescription* scene, double box_radius_m, const std::string& rungs) : rungs_(rungs) {
        if (scene != nullptr)
            depth_.emplace(*scene, GlDepthOptions{.box_radius_m = box_radius_m});
    }

    /// `later_s`: carried on by so much.
    EyePicture see(const ReceivedFrame& frame, const ReceivedFrame& before, EyeView eye, double later_s = 0) {
        const FloatImage before_m = depth_of(before.main);
        FloatImage eye_m;
        if (depth_) {
            depth_->set_time(frame.main.info.time_s + later_s);
            eye_m = cast(eye.camera, eye.pose);
            eye.depth_m = eye_m.view();
        }
        const FloatImage main_m = depth_of(frame.main);
        CarriedPicture carried;
        if (later_s > 0)
            PictureCarrier().carry_on(frame.main, main_m, later_s, carried);
        const SourceView main =
            later_s > 0 ? source_view(carried.picture, carried.depth_m) : source_view(frame.main, main_m);
        const std::array earlier = {source_view(before.main, before_m)};
        std::optional<SourceView> hidden, small;
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
        const auto engine = make_engine(depth_ ? "surface" : "mesh");
        engine->set_source(main);
        EyePicture picture;
        engine->reproject(eye, picture);
        mirrored += rework_specular(main, eye, picture).by_image;
        const FillLadder ladder = make_fill_ladder(rungs_);
        for (const auto& rung : ladder)
            rung->set_frame({.main = &main,
                             .small = small ? &*small : nullptr,
                             .earlier = earlier,
                             .hidden = hidden ? &*hidden : nullptr,
                             .patches = patches ? &*patches : nullptr});
        fill_gaps(ladder, eye, picture);
        estimate_reliability(main, eye, picture, {.specular_reworked = true});
        return picture;
    }

    std::int64_t mirrored = 0;  ///< pixels that were looked up by images

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

    std::string rungs_;
    std::optional<GlDepth> depth_;
};

double psnr_db(const ByteImage& a, const ByteImage& b) {
    double squares = 0;
    for (std::size_t i = 0; i < a.samples().size(); ++i)
        squares += std::pow(double(a.samples()[i]) - double(b.samples()[i]), 2);
    return 10 * std::log10(255.0 * 255 * double(a.samples().size()) / std::max(squares, 1e-9));
}

/// Of a refresh's two pictures.
void expect_same(const EyePicture& found, const EyePicture& expected) {
    EXPECT_GT(psnr_db(found.rgba, expected.rgba), 50);
    EXPECT_EQ(found.count(PixelOrigin::gap), 0);
    const double pixels = double(found.origin.samples().size());
    int other_origins = 0, other_reliabilities = 0;
    for (std::size_t p = 0; p < found.origin.samples().size(); ++p) {
        other_origins += found.origin.samples()[p] != expected.origin.samples()[p];
        other_reliabilities += std::abs(found.reliability.samples()[p] - expected.reliability.samples()[p]) > 2;
    }
    EXPECT_LT(other_origins, 0.002 * pixels);
    EXPECT_LT(other_reliabilities, 0.01 * pixels);
}

class GlRefresh : public GlEyeRenderer {
protected:
    /// Two eyes see the same as on the CPU, by the scene's geometry, and, without a scene, by the frame's own depth.
    /// These rungs, among others, have something to do.
    void expect_the_cpus(const std::string& rungs, std::initializer_list<PixelOrigin> used) {
        for (const SceneDescription* geometry : {static_cast<const SceneDescription*>(&scene), {}}) {
            SCOPED_TRACE(geometry != nullptr ? "by geometry" : "by the frame's depth");
            const auto before = make_frame(0, flat, geometry == nullptr),
                       frame = make_frame(1, flat, geometry == nullptr);
            const double radius_m = head_box_radius(frame->main.info);
            gl::EyeRenderer renderer(geometry, radius_m);
            renderer.set_rungs(gl::parse_rungs(rungs));
            gl::StageTimes times;
            gl::EyeTargets targets;
            const auto eyes = eyes_at({{0.01, 0.005, 0.01}, {1, 0, 0, 0}});
            for (const auto& shown : {before, frame}) {
                renderer.show(shown, times);
                renderer.look(eyes, true, times);
                renderer.draw({.reliability = true}, targets, times);
            }
            EXPECT_TRUE(renderer.has_depth());
            OnTheCpu cpu(geometry, radius_m, rungs);
            for (std::size_t i = 0; i < eyes.size(); ++i) {
                SCOPED_TRACE(i);
                EyePicture found;
                targets.download(int(i), found);
                renderer.download_reliability(int(i), found);
                expect_same(found, cpu.see(*frame, *before, eyes[i]));
                for (const PixelOrigin rung : used)
                    EXPECT_TRUE(i == 0 || found.count(rung) > 0) << int(rung);
            }
            EXPECT_GT(cpu.mirrored, 100);
        }
    }
};

TEST_F(GlRefresh, ShowsWhatTheCpuMakesOfTheFrame) {
    expect_the_cpus(default_fill, {PixelOrigin::hidden, PixelOrigin::patches});
}

/// By the small view's depth, and, without a scene, by direction alone.
TEST_F(GlRefresh, FillsFromTheSmallSecondEye) {
    expect_the_cpus("small-wide,hidden,small,pushpull", {PixelOrigin::small});
}

TEST(GlRungs, AreThoseOfAList) {
    EXPECT_EQ(gl::parse_rungs("small-wide,hidden"), (std::vector{gl::Rung::small_wide, gl::Rung::hidden}));
    EXPECT_TRUE(gl::parse_rungs("none").empty());
    EXPECT_THROW(gl::parse_rungs("hidden,geometry"), InputError);
}

/// What moves is where it is by then, in the eyes' pictures too, and nothing is left where it was.
TEST_F(GlEyeRenderer, CarriesOnWhatMovesAsTheCpuDoes) {
    for (const Camera& camera : {Camera(flat), Camera(EquirectCamera{640, 320, {}})}) {
        const auto before = make_moving_frame(0, camera), frame = make_moving_frame(1, camera);
        const double radius_m = head_box_radius(frame->main.info);
        gl::EyeRenderer renderer(&moving_scene, radius_m);
        OnTheCpu cpu(&moving_scene, radius_m);
        gl::StageTimes times;
        gl::EyeTargets targets;
        const auto eyes = eyes_at({{0.01, 0.005, 0.01}, {1, 0, 0, 0}});
        std::array<EyePicture, 2> held;
        for (const double later_s : {0.0, 0.05, 0.12}) {
            for (const auto& shown : {before, frame}) {
                renderer.show(shown, times);
                EXPECT_TRUE(renderer.can_carry_on());
                renderer.carry_on(shown == frame ? later_s : 0);
                renderer.look(eyes, true, times);
                renderer.draw({}, targets, times);
            }
            for (std::size_t i = 0; i < eyes.size(); ++i) {
                EyePicture found;
                targets.download(int(i), found);
                const EyePicture expected = cpu.see(*frame, *before, eyes[i], later_s);
                EXPECT_GT(psnr_db(found.rgba, expected.rgba), 50) << camera.index() << ' ' << later_s << ' ' << i;
                EXPECT_EQ(found.count(PixelOrigin::gap), 0);
                if (later_s == 0)
                    held[i] = expected;
                else
                    EXPECT_LT(psnr_db(held[i].rgba, expected.rgba), 30) << "it has moved";
            }
        }
    }
}

/// As it is seen from each eye, where what moves is then and nowhere else; by direction alone too.
TEST_F(GlEyeRenderer, TellsHowWhatIsSeenMoves) {
    const auto frame = make_moving_frame(0, EquirectCamera{640, 320, {}});
    const auto eyes = eyes_at({{0.01, 0.005, 0.01}, yaw_pitch(0.1, 0.05)});
    const auto expect_told = [&](gl::EyeRenderer& renderer, double later_s, double relative, double elsewhere_share) {
        gl::StageTimes times;
        gl::EyeTargets targets;
        renderer.show(frame, times);
        renderer.carry_on(later_s);
        renderer.look(eyes, true, times);
        renderer.draw({.motion = true}, targets, times);
        const glm::dvec3 centre_m = glm::dvec3(0, 0, -1.2) + later_s * ball_m_s;
        std::vector<glm::vec4> told(320 * 200);
        for (std::size_t i = 0; i < eyes.size(); ++i) {
            gl::download(renderer.motion(), int(i), {320, 200}, {GL_RGBA, GL_FLOAT, sizeof(glm::vec4)}, told.data(),
                         320 * sizeof(glm::vec4));
            int moving = 0, elsewhere = 0, wrong = 0;
            for (int y = 0; y < 200; ++y)
                for (int x = 0; x < 320; ++x) {
                    const glm::vec4 found = told[std::size_t(320 * y + x)];
                    const Pose& eye = eyes[i].pose;
                    const glm::dvec3 d = eye.orientation * eyes[i].camera.direction(x + 0.5, y + 0.5);
                    const double r = to_sphere(eye.position_m, d, centre_m, 0.3);
                    elsewhere += (found.z > 0) != (r < infinity);
                    if (!(r < infinity) || !(found.z > 0))
                        continue;
                    ++moving;
                    const glm::dvec3 across = (ball_m_s - glm::dot(ball_m_s, d) * d) / r;
                    const glm::dvec2 expected(glm::dot(across, eye.orientation * glm::dvec3(1, 0, 0)),
                                              glm::dot(across, eye.orientation * glm::dvec3(0, -1, 0)));
                    wrong += glm::length(glm::dvec2(found) - expected) > relative * glm::length(expected);
                }
            EXPECT_GT(moving, 2000) << later_s;
            EXPECT_LT(elsewhere, elsewhere_share * moving) << later_s;
            EXPECT_LT(wrong, 0.05 * moving) << later_s;
        }
    };
    gl::EyeRenderer renderer(&moving_scene, 0.0315);
    expect_told(renderer, 0, 0.02, 0.05);
    expect_told(renderer, 0.1, 0.02, 0.1);  // a side of it comes into view of which no frame told
    gl::EyeRenderer by_direction(nullptr, 0.0315);
    // It may be anywhere between the region's nearest and farthest, and is seen from the source's centre.
    expect_told(by_direction, 0, 0.6, 0.25);
    gl::StageTimes times;
    by_direction.show(make_frame(0, flat, false), times);
    gl::EyeTargets targets;
    by_direction.look(eyes, true, times);
    by_direction.draw({.motion = true}, targets, times);
    EXPECT_EQ(by_direction.motion(), 0U) << "nothing is said to move";
}

/// A frame that says that something moves of which the scene knows nothing, or nothing of what the scene moves.
TEST_F(GlEyeRenderer, CarriesOnOnlyWhatFrameAndSceneKnowOf) {
    gl::StageTimes times;
    const auto carries = [&](const SceneDescription* of, const std::shared_ptr<const ReceivedFrame>& frame) {
        gl::EyeRenderer renderer(of, 0.0315);
        renderer.show(frame, times);
        return renderer.can_carry_on();
    };
    EXPECT_TRUE(carries(&moving_scene, make_moving_frame(0, flat)));
    EXPECT_FALSE(carries(&scene, make_moving_frame(0, flat)));
    EXPECT_FALSE(carries(nullptr, make_moving_frame(0, flat)));
    EXPECT_FALSE(carries(&moving_scene, make_frame(0, flat, false)));
}

/// The same walk twice: what the second makes would be made for ever.
TEST_F(GlEyeRenderer, MakesNothingOnceItHasDrawnAll) {
    const Camera sphere = EquirectCamera{256, 128, {}};
    for (const auto& [by_geometry, camera] : {std::pair{true, Camera(flat)}, {true, sphere}, {false, sphere}}) {
        std::vector<std::shared_ptr<const ReceivedFrame>> frames;
        for (std::int64_t i = 0; i < 6; ++i)
            frames.push_back(i < 3 || !by_geometry ? make_frame(i, camera, !by_geometry)
                                                   : make_moving_frame(i, camera));
        gl::EyeRenderer renderer(by_geometry ? &moving_scene : nullptr, head_box_radius(frames[0]->main.info));
        gl::StageTimes times;
        gl::EyeTargets targets, other_targets;
        const auto walk = [&] {
            for (const auto& frame : frames) {
                times.start(true);
                renderer.show(frame, times);
                const double t = frame->main.info.time_s;
                const auto eyes = eyes_at({{0.1 * t, 0.05 * t, 0}, yaw_pitch(2 * t, t)});
                for (const double later_s : {0.0, 0.02}) {
                    renderer.carry_on(later_s);
                    renderer.look(eyes, true, times);
                    renderer.draw({.reliability = true, .motion = true}, targets, times);
                    renderer.draw({.surface = false}, other_targets, times);
                }
            }
        };
        walk();
        GLuint framebuffer = 0;
        glCreateFramebuffers(1, &framebuffer);
        const gl::Framebuffer owner(framebuffer);
        const MadeObjects made;
        {
            const CountedMemory memory;
            walk();
            EXPECT_EQ(memory.allocations(), 0);
            const auto counted = std::make_unique<int>(3);
            EXPECT_EQ(memory.allocations(), *counted - 2) << "memory counts";
        }
        EXPECT_EQ(made.count(), 0);
    }
}

}  // namespace
}  // namespace equistream::test
