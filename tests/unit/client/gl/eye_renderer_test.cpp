/// A whole refresh of the viewer: held to what the CPU makes of the same frame, and without anything being made, on the
/// GPU or in memory, once everything was drawn.
#include "eye_renderer_stage.h"
#include "made_objects.h"
#include "recorded_calls.h"

#include <client/view/gl/eye_renderer.h>
#include <tests/unit/client/counted_memory.h>

#include <equistream/error.h>

#include <initializer_list>
#include <tuple>
#include <utility>
#include <vector>

namespace equistream::test {
namespace {

class GlRefresh : public GlEyeRenderer {
protected:
    /// Two eyes see the same as on the CPU, by the scene's geometry, and, without a scene, by the frame's own depth.
    /// These fill passes, among others, have something to do.
    void expect_the_cpus(const std::string& passes, std::initializer_list<PixelOrigin> used,
                         MirrorTreatment mirrors = MirrorTreatment::images, const Limits& limits = {}) {
        for (const SceneDescription* geometry : {static_cast<const SceneDescription*>(&scene), {}}) {
            SCOPED_TRACE(geometry != nullptr ? "by geometry" : "by the frame's depth");
            const auto before = make_frame(0, flat, geometry == nullptr),
                       frame = make_frame(1, flat, geometry == nullptr);
            const double radius_m = head_box_radius(frame->main.info);
            gl::EyeRenderer renderer(geometry, radius_m, passes);
            gl::StageTimes times;
            gl::EyeTargets targets;
            const auto eyes = eyes_at({{0.01, 0.005, 0.01}, {1, 0, 0, 0}});
            for (const auto& shown : {before, frame}) {
                renderer.show(shown, times);
                renderer.look(eyes, true, times);
                renderer.draw({.reliability = true, .mirrors = mirrors}, targets, times);
            }
            EXPECT_TRUE(renderer.has_depth());
            OnTheCpu cpu(geometry, radius_m, passes);
            cpu.mirrors = mirrors;
            for (std::size_t i = 0; i < eyes.size(); ++i) {
                SCOPED_TRACE(i);
                EyePicture found;
                targets.download(int(i), found);
                renderer.download_reliability(int(i), found);
                expect_same(found, cpu.see(*frame, *before, eyes[i]), limits);
                for (const PixelOrigin fill_pass : used)
                    EXPECT_TRUE(i == 0 || found.count(fill_pass) > 0) << int(fill_pass);
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
    expect_the_cpus("small,hidden,pushpull", {PixelOrigin::small});
}

/// The eye beside the earlier picture's place sees in the mirror what that one saw; the other one does not.
TEST_F(GlRefresh, PassesMirrorsOverInGaps) {
    expect_the_cpus("earlier,pushpull", {PixelOrigin::push_pull}, MirrorTreatment::gaps, large_fills);
}

/// Without a scene, by another engine than the default; `proxy-sphere` without any depth too.
class GlRefreshByEngine : public GlEyeRenderer, public testing::WithParamInterface<std::tuple<const char*, bool>> {};

TEST_P(GlRefreshByEngine, ShowsWhatTheCpuMakesOfTheFrame) {
    const auto [engine, with_depth] = GetParam();
    const auto before = make_frame(0, flat, with_depth), frame = make_frame(1, flat, with_depth);
    const double radius_m = head_box_radius(frame->main.info);
    gl::EyeRenderer renderer(nullptr, radius_m, default_fill, engine);
    gl::StageTimes times;
    gl::EyeTargets targets;
    const auto eyes = eyes_at({{0.01, 0.005, 0.01}, {1, 0, 0, 0}});
    for (const auto& shown : {before, frame}) {
        renderer.show(shown, times);
        EXPECT_TRUE(renderer.has_depth());
        renderer.look(eyes, true, times);
        renderer.draw({.reliability = true}, targets, times);
    }
    const bool is_known = std::string_view(engine) != "lean";
    EXPECT_EQ(renderer.depth().texture != 0, is_known);
    OnTheCpu cpu(nullptr, radius_m, default_fill, engine);
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        EyePicture found;
        targets.download(int(i), found);
        renderer.download_reliability(int(i), found);
        expect_same(found, cpu.see(*frame, *before, eyes[i]), Limits{});
    }
}

INSTANTIATE_TEST_SUITE_P(Client, GlRefreshByEngine,
                         testing::Values(std::tuple("mesh-plain", true), std::tuple("lean", true),
                                         std::tuple("lean", false)));

/// A sphere rendered for each eye, with depth: each eye is made of the one that was seen from nearer by.
TEST_F(GlRefresh, ReprojectsEachEyeFromTheNearestSphere) {
    constexpr int left = 60, right = 200;
    const auto sphere = [](int brightness, double x_m) {
        ReceivedPicture picture;
        picture.info.camera = EquirectCamera{64, 32, {}};
        picture.info.camera_pose.position_m = {x_m, 0, 0};
        picture.info.eye = x_m < 0 ? Eye::left : Eye::right;
        picture.rgb = ByteImage(64, 32, 3, std::uint8_t(brightness));
        picture.depth_m = FloatImage(64, 32, 1, 3.0f);
        return picture;
    };
    const auto both = std::make_shared<ReceivedFrame>();
    both->main = sphere(left, -0.0315);
    both->right = sphere(right, 0.0315);
    for (const char* engine : {"mesh", "lean"}) {
        gl::EyeRenderer renderer(nullptr, 0.163, "none", engine);
        gl::StageTimes times;
        gl::EyeTargets targets;
        renderer.show(both, times);
        const auto seen = [&](const Pose& head) {
            const auto eyes = eyes_at(head);
            renderer.look(eyes, true, times);
            renderer.draw({}, targets, times);
            std::vector<int> brightness;
            for (int i = 0; i < 2; ++i) {
                EyePicture picture;
                targets.download(i, picture);
                EXPECT_EQ(picture.count(PixelOrigin::gap), 0) << engine;
                brightness.push_back(picture.rgba.pixel(160, 100)[1]);
            }
            return brightness;
        };
        EXPECT_EQ(seen({{0.01, 0, 0}, {1, 0, 0, 0}}), (std::vector{left, right})) << engine;
        EXPECT_EQ(renderer.depth().texture != 0, std::string_view(engine) == "mesh");
        // Turned round, the left eye stands where the right one's sphere was seen from.
        EXPECT_EQ(seen({{0, 0, 0}, {0, 0, 1, 0}}), (std::vector{right, left})) << engine;
        // Ten centimetres to the left both are nearer to the left one's.
        EXPECT_EQ(seen({{-0.1, 0, 0}, {1, 0, 0, 0}}), (std::vector{left, left})) << engine;
    }
}

/// Of foreign stereo video; and of a frame after it without a second eye.
TEST_F(GlRefresh, TurnsEachEyesOwnSphere) {
    constexpr int left = 60, right = 200;
    const auto sphere = [](int brightness) {
        ReceivedPicture picture;
        picture.info.camera = EquirectCamera{64, 32, {}};
        picture.rgb = ByteImage(64, 32, 3, std::uint8_t(brightness));
        return picture;
    };
    const auto both = std::make_shared<ReceivedFrame>(), one = std::make_shared<ReceivedFrame>();
    both->posed = one->posed = false;
    both->main = one->main = sphere(left);
    both->right = sphere(right);
    gl::EyeRenderer renderer(nullptr, 0.1);
    gl::StageTimes times;
    gl::EyeTargets targets;
    const auto eyes = eyes_at({{0, 0, 0}, {1, 0, 0, 0}});
    const auto seen = [&](std::size_t count, bool right_alone) {
        renderer.look(std::span(eyes).first(count), true, times);
        renderer.draw({.right_alone = right_alone}, targets, times);
        std::vector<int> brightness;
        for (std::size_t i = 0; i < count; ++i) {
            EyePicture picture;
            targets.download(int(i), picture);
            EXPECT_EQ(picture.count(PixelOrigin::gap), 0);
            brightness.push_back(picture.rgba.pixel(160, 100)[1]);
        }
        return brightness;
    };
    renderer.show(both, times);
    EXPECT_EQ(seen(2, false), (std::vector{left, right}));
    EXPECT_EQ(seen(1, false), (std::vector{left}));
    EXPECT_EQ(seen(1, true), (std::vector{right}));
    renderer.show(one, times);
    EXPECT_EQ(seen(2, false), (std::vector{left, left}));
    EXPECT_EQ(seen(1, true), (std::vector{left}));
}

TEST_F(GlRefresh, PassesAreThoseOfAList) {
    gl::GlFillShared shared;
    const gl::GlFillChain chain = gl::make_gl_fill_chain("small,hidden", shared);
    ASSERT_EQ(chain.size(), 2u);
    EXPECT_EQ(chain[0]->name(), "small");
    EXPECT_EQ(chain[1]->name(), "hidden");
    std::vector<std::string> notes;
    EXPECT_EQ(gl::with_passes_of_gpu("small-wide,hidden,geometry,spread", notes), "small,hidden,pushpull");
    EXPECT_EQ(notes, (std::vector<std::string>{"--fill small-wide is in play only: small is used",
                                               "--fill geometry is in play only: it is ignored",
                                               "--fill spread is in play only: pushpull is used"}));
    EXPECT_EQ(gl::with_passes_of_gpu("geometry", notes), "none");
    EXPECT_TRUE(gl::make_gl_fill_chain("none", shared).empty());
    EXPECT_THROW(gl::make_gl_fill_chain("hidden,earliest", shared), InputError);
}

constexpr const char* by_geometry = "geometry";  // or by the frame's own depth, which an engine of this name finds

/// What moves is where it is by then, in the eyes' pictures too, and nothing is left where it was.
class GlExtrapolated : public GlEyeRenderer,
                       public testing::WithParamInterface<std::tuple<const char*, bool, Mirror>> {};

TEST_P(GlExtrapolated, ShowsWhatTheCpuShows) {
    const auto [depth, of_sphere, mirror] = GetParam();
    const SceneDescription* const geometry = std::string_view(depth) == by_geometry ? &moving_scene : nullptr;
    const std::string engine = geometry != nullptr ? "mesh" : depth;
    const Camera camera = of_sphere ? Camera(EquirectCamera{640, 320, {}}) : Camera(flat);
    const auto before = make_moving_frame(0, camera, mirror, geometry == nullptr),
               frame = make_moving_frame(1, camera, mirror, geometry == nullptr);
    const double radius_m = head_box_radius(frame->main.info);
    gl::EyeRenderer renderer(geometry, radius_m, default_fill, engine);
    OnTheCpu cpu(geometry, radius_m, default_fill, engine);
    gl::StageTimes times;
    gl::EyeTargets targets;
    const auto eyes = eyes_at({{0.01, 0.005, 0.01}, {1, 0, 0, 0}});
    std::array<EyePicture, 2> held;
    for (const double extrapolation_s : {0.0, 0.05, 0.12}) {
        for (const auto& shown : {before, frame}) {
            renderer.show(shown, times);
            EXPECT_TRUE(renderer.can_extrapolate());
            renderer.extrapolate(shown == frame ? extrapolation_s : 0);
            renderer.look(eyes, true, times);
            renderer.draw({.reliability = true}, targets, times);
        }
        for (std::size_t i = 0; i < eyes.size(); ++i) {
            SCOPED_TRACE(testing::Message() << extrapolation_s << ' ' << i);
            EyePicture found;
            targets.download(int(i), found);
            renderer.download_reliability(int(i), found);
            const EyePicture expected = cpu.see(*frame, *before, eyes[i], extrapolation_s);
            expect_same(found, expected, Limits{});
            if (extrapolation_s == 0)
                held[i] = expected;
            else
                EXPECT_LT(psnr_db(held[i].rgba, expected.rgba), 30) << "it has moved";
        }
    }
    EXPECT_TRUE(mirror == Mirror::none || cpu.mirrored > 100) << cpu.mirrored;
}

INSTANTIATE_TEST_SUITE_P(
    Pictures, GlExtrapolated,
    testing::Values(std::tuple(by_geometry, false, Mirror::none), std::tuple(by_geometry, true, Mirror::none),
                    std::tuple(by_geometry, false, Mirror::wall), std::tuple(by_geometry, false, Mirror::ball),
                    std::tuple("mesh", false, Mirror::none), std::tuple("mesh", true, Mirror::none),
                    std::tuple("mesh", false, Mirror::wall), std::tuple("mesh", false, Mirror::ball),
                    std::tuple("mesh-plain", true, Mirror::none)));

/// As on the CPU: it would see what has moved where it was, too.
TEST_F(GlEyeRenderer, CarriesNothingOnForAnEyeAtTheSource) {
    gl::StageTimes times;
    gl::EyeTargets targets;
    const auto frame = make_moving_frame(0, flat, Mirror::none, true);
    std::array eyes = eyes_at({{0.01, 0.005, 0.01}, {1, 0, 0, 0}});
    for (const bool at_source : {false, true}) {
        if (at_source)
            eyes[1].pose = frame->main.info.camera_pose;
        gl::EyeRenderer renderer(nullptr, 0.0315);
        renderer.show(frame, times);
        std::array<EyePicture, 2> pictures;
        for (const bool later : {false, true}) {
            renderer.extrapolate(later ? 0.1 : 0);
            renderer.look(eyes, true, times);
            renderer.draw({}, targets, times);
            targets.download(0, pictures[std::size_t(later)]);
            EXPECT_EQ(renderer.extrapolated_s(), later && !at_source ? 0.1 : 0);
        }
        EXPECT_EQ(psnr_db(pictures[0].rgba, pictures[1].rgba) > 100, at_source);
    }
}

/// Whatever there is no memory for at a size: once there is, all is drawn.
TEST_F(GlEyeRenderer, DrawsAllOnceThereIsMemoryForIt) {
    gl::StageTimes times;
    gl::EyeTargets targets;
    gl::EyeRenderer renderer(nullptr, 0.1);
    for (const int index : {0, 1})
        renderer.show(make_moving_frame(index, flat, Mirror::wall, true), times);
    const auto seen = [&](int width, int height) {
        auto eyes = eyes_at({{0.01, 0.005, 0.01}, {1, 0, 0, 0}});
        for (EyeView& eye : eyes)
            eye.camera = {width, height, pi / 2};
        renderer.look(eyes, true, times);
        renderer.draw({.reliability = true, .motion = true}, targets, times);
        EyePicture picture;
        targets.download(1, picture);
        renderer.download_reliability(1, picture);
        return picture;
    };
    const EyePicture expected = seen(160, 100);
    int failures = 0;
    for (bool has_enough = false; !has_enough;) {
        seen(150, 90);
        try {
            const NoMemory none(failures);
            seen(160, 100);
            has_enough = true;
        } catch (const WorkError&) {
            SCOPED_TRACE(++failures);
            expect_same(seen(160, 100), expected, Limits{});
        }
    }
    EXPECT_GT(failures, 15);
}

/// Of another frame that there is no memory for.
TEST_F(GlEyeRenderer, KeepsTheFrameBefore) {
    gl::StageTimes times;
    gl::EyeRenderer renderer(nullptr, 0.1);
    renderer.show(make_frame(0, flat, true), times);
    auto next = std::make_shared<ReceivedFrame>(*make_frame(1, flat, true));
    next->hidden.reset();
    next->patches.reset();
    // Three textures of pictures, and two of mirrors.
    for (int tries = 0; tries < 2; ++tries) {
        const NoMemory none(2);
        EXPECT_THROW(renderer.show(next, times), WorkError);
        EXPECT_EQ(renderer.frame().main.info.index, 0);
    }
    renderer.show(next, times);
    EXPECT_EQ(renderer.frame().main.info.index, 1);
}

/// Where something moves a mesh is built anew, and nowhere else.
TEST_F(GlEyeRenderer, BuildsAnewWhatMovingThingsLeaveAndReach) {
    gl::EyeRenderer renderer(nullptr, 0.0315);
    gl::StageTimes times;
    const auto eyes = eyes_at({{0.01, 0, 0}, {1, 0, 0, 0}});
    renderer.show(make_moving_frame(0, EquirectCamera{1024, 512, {}}, Mirror::none, true), times);
    // And what was extrapolated, which is at each refresh.
    const auto built = [&](double extrapolation_s) {
        const IndirectGroups groups;
        renderer.extrapolate(extrapolation_s);
        renderer.look(eyes, true, times);
        return groups.count();
    };
    const std::int64_t all = built(0);
    EXPECT_GT(all, 100);
    for (const double extrapolation_s : {0.02, 0.05, 0.1, 0.0}) {
        const std::int64_t some = built(extrapolation_s), extrapolated = built(extrapolation_s);
        EXPECT_GT(some - extrapolated, 4) << extrapolation_s;
        EXPECT_LT(some - extrapolated, all / 2) << extrapolation_s;
        EXPECT_EQ(built(extrapolation_s), extrapolated) << extrapolation_s;
    }
}

/// As it is seen from each eye, where what moves is then and nowhere else; by direction alone too.
TEST_F(GlEyeRenderer, TellsHowWhatIsSeenMoves) {
    const auto frame = make_moving_frame(0, EquirectCamera{640, 320, {}});
    const auto eyes = eyes_at({{0.01, 0.005, 0.01}, yaw_pitch(0.1, 0.05)});
    const auto expect_told = [&](gl::EyeRenderer& renderer, double extrapolation_s, double relative,
                                 double elsewhere_share) {
        gl::StageTimes times;
        gl::EyeTargets targets;
        renderer.show(frame, times);
        renderer.extrapolate(extrapolation_s);
        renderer.look(eyes, true, times);
        renderer.draw({.motion = true}, targets, times);
        const glm::dvec3 centre_m = glm::dvec3(0, 0, -1.2) + extrapolation_s * ball_m_s;
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
            EXPECT_GT(moving, 2000) << extrapolation_s;
            EXPECT_LT(elsewhere, elsewhere_share * moving) << extrapolation_s;
            EXPECT_LT(wrong, 0.05 * moving) << extrapolation_s;
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
        return renderer.can_extrapolate();
    };
    EXPECT_TRUE(carries(&moving_scene, make_moving_frame(0, flat)));
    EXPECT_FALSE(carries(&scene, make_moving_frame(0, flat)));
    EXPECT_FALSE(carries(nullptr, make_moving_frame(0, flat)));
    EXPECT_TRUE(carries(nullptr, make_moving_frame(0, flat, Mirror::none, true)));
    EXPECT_FALSE(carries(nullptr, make_frame(0, flat, true)));
    EXPECT_FALSE(carries(&moving_scene, make_frame(0, flat, false)));
}

/// The small view's once a frame, the source's from all around only when something is extrapolated: a draw each, and
/// two for what eyes see at each refresh.
TEST_F(GlEyeRenderer, DrawsDepthOnceAFrameWhereNoEyeMatters) {
    auto frame = std::make_shared<ReceivedFrame>(*make_moving_frame(0, EquirectCamera{256, 128, {}}));
    frame->small = make_frame(0, EquirectCamera{128, 64, {}})->small;
    gl::EyeRenderer renderer(&moving_scene, 0.0315, "small");
    gl::StageTimes times;
    const auto eyes = eyes_at({{0.01, 0, 0}, {1, 0, 0, 0}});
    for (int shown = 0; shown < 2; ++shown) {
        renderer.show(frame, times);
        const auto draws = [&](double extrapolation_s) {
            const RecordedCalls calls;
            renderer.extrapolate(extrapolation_s);
            renderer.look(eyes, true, times);
            return calls.draws();
        };
        EXPECT_EQ(draws(0), 1 + 2);
        EXPECT_EQ(draws(0), 2) << "the small view's is known";
        EXPECT_EQ(draws(0.02), 1 + 2);
        EXPECT_EQ(draws(0.03), 2) << "the source's is known";
        EXPECT_EQ(draws(0), 2) << "and kept";
    }
}

/// What samples of other pictures show is drawn forward only while there are gaps.
TEST_F(GlEyeRenderer, DrawsForwardOnlyIntoGaps) {
    const auto frame = make_frame(0, flat, true);
    gl::EyeRenderer renderer(nullptr, 0.1, "hidden");
    gl::StageTimes times;
    gl::EyeTargets targets;
    renderer.show(frame, times);
    const auto groups = [&](const glm::dvec3& at) {
        const EyeView eye{{320, 200, pi / 2}, {at, {1, 0, 0, 0}}, {}};
        renderer.look(std::span(&eye, 1), true, times);
        renderer.draw({}, targets, times);
        const IndirectGroups counted;
        renderer.draw({}, targets, times);
        return counted.count();
    };
    const glm::dvec3 own = frame->main.info.camera_pose.position_m;
    constexpr std::int64_t of_hidden = (400 / gl::group_width) * (250 / gl::group_height);
    EXPECT_GT(groups(own + glm::dvec3(0.1, 0, 0)), of_hidden);
    EXPECT_LT(groups(own), of_hidden / 2);
}

constexpr const char* all_passes = "hidden,patches,earlier,small,pushpull";

class GlSteadyRefreshes : public GlEyeRenderer, public testing::WithParamInterface<std::tuple<bool, bool>> {
protected:
    /// Still ones and such that are extrapolated, with all that gaps may be filled from. An even number: what one had
    /// in the first walk it has again.
    static std::vector<std::shared_ptr<const ReceivedFrame>> frames(bool with_depth, const Camera& camera) {
        return {make_frame(0, camera, with_depth), make_frame(1, camera, with_depth),
                make_moving_frame(2, camera, Mirror::wall, with_depth),
                make_moving_frame(3, camera, Mirror::wall, with_depth)};
    }
};

/// The same walk twice in each layout: what the second makes would be made for ever.
TEST_P(GlSteadyRefreshes, MakeNothingOnceAllWasDrawn) {
    const auto [with_depth, of_sphere] = GetParam();
    const Camera camera =
        of_sphere ? Camera(EquirectCamera{128, 64, {}}) : Camera(PerspectiveCamera{160, 100, flat.fov_x_rad});
    const auto walked = frames(with_depth, camera);
    SceneDescription coarse = moving_scene;
    coarse.file = coarse.model = folder->path() / "coarse.obj";
    write_model(coarse.model, 12);
    gl::EyeRenderer renderer(with_depth ? nullptr : &coarse, head_box_radius(walked[0]->main.info), all_passes);
    gl::StageTimes times;
    gl::EyeTargets targets, other_targets;
    const auto walk = [&](std::size_t eye_count) {
        for (const auto& frame : walked) {
            times.start(true);
            renderer.show(frame, times);
            const double t = frame->main.info.time_s;
            auto both = eyes_at({{0.1 * t, 0.05 * t, 0}, yaw_pitch(2 * t, t)});
            for (EyeView& eye : both)
                eye.camera = {96, 60, pi / 2};
            const std::span eyes = std::span(both).first(eye_count);
            for (const double extrapolation_s : {0.0, 0.02}) {
                renderer.extrapolate(extrapolation_s);
                renderer.look(eyes, true, times);
                renderer.draw({.reliability = true, .motion = true}, targets, times);
            }
            renderer.draw({.surface = false}, other_targets, times);
        }
    };
    GLuint framebuffer = 0;
    glCreateFramebuffers(1, &framebuffer);
    const gl::Framebuffer owner(framebuffer);
    for (const std::size_t eye_count : {2, 1}) {
        walk(eye_count);
        const MadeObjects made;
        const CountedMemory memory;
        walk(eye_count);
        EXPECT_EQ(memory.allocations(), 0);
        EXPECT_EQ(made.count(), 0);
    }
    const CountedMemory memory;
    const auto one = std::make_unique<int>(3);
    EXPECT_EQ(memory.allocations(), 1) << "memory counts: " << *one;
}

INSTANTIATE_TEST_SUITE_P(Frames, GlSteadyRefreshes,
                         testing::Values(std::tuple(false, false), std::tuple(false, true), std::tuple(true, true)));

}  // namespace
}  // namespace equistream::test
