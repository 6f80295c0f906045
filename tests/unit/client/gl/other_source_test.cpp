/// Sources after others: what was found of one is not used for the next one, whose camera may be another; and windows
/// within spheres, which are such.
#include "eye_renderer_stage.h"
#include "filled_pictures.h"
#include "made_objects.h"

#include <client/view/gl/eye_renderer.h>
#include <tests/unit/client/counted_memory.h>

#include <algorithm>
#include <optional>
#include <span>
#include <string>

namespace equistream::test {
namespace {

using Frame = std::shared_ptr<const ReceivedFrame>;

const Pose somewhere{{0.02, 0.005, 0.01}, {1, 0, 0, 0}};

class GlOtherSource : public GlEyeRenderer, public testing::WithParamInterface<std::string_view> {
protected:
    static std::array<EyePicture, 2> seen(gl::EyeRenderer& renderer, const Frame& frame,
                                          const gl::RefreshOptions& how) {
        gl::StageTimes times;
        gl::EyeTargets targets;
        const auto eyes = eyes_at(somewhere);
        renderer.show(frame, times);
        renderer.look(eyes, true, times);
        renderer.draw(how, targets, times);
        std::array<EyePicture, 2> pictures;
        for (std::size_t i = 0; i < 2; ++i)
            targets.download(int(i), pictures[i]);
        return pictures;
    }
    /// The first and then the second one, and the second one alone.
    static void expect_as_if_first(const Frame& first, const Frame& second, const std::string& passes) {
        const double radius_m = head_box_radius(second->main.info);
        gl::EyeRenderer after(nullptr, radius_m, passes, GetParam()), alone(nullptr, radius_m, passes, GetParam());
        const auto of_first = seen(after, first, {}), found = seen(after, second, {}),
                   expected = seen(alone, second, {});
        for (std::size_t i = 0; i < 2; ++i) {
            EXPECT_TRUE(std::ranges::equal(found[i].rgba.samples(), expected[i].rgba.samples()));
            EXPECT_TRUE(std::ranges::equal(found[i].origin.samples(), expected[i].origin.samples()));
            EXPECT_FALSE(std::ranges::equal(of_first[i].rgba.samples(), expected[i].rgba.samples()));
        }
    }
};

/// The same picture from nearer: nothing but its depth is another.
TEST_P(GlOtherSource, DepthIsFoundAnewOfTheNextOne) {
    const Frame frame = make_frame(0, flat, true);
    const auto nearer = std::make_shared<ReceivedFrame>(*frame);
    for (float& r : nearer->main.depth_m.samples())
        r *= 0.6f;
    expect_as_if_first(frame, nearer, "hidden,pushpull");
}

TEST_P(GlOtherSource, OfOneWithoutDepthNoneIsKnown) {
    const Frame frame = make_frame(0, flat, true);
    const auto without = std::make_shared<ReceivedFrame>(*frame);
    without->main.depth_m = {};
    expect_as_if_first(frame, without, "hidden,small,pushpull");
    gl::EyeRenderer renderer(nullptr, head_box_radius(frame->main.info), default_fill, GetParam());
    seen(renderer, frame, {});
    EXPECT_NE(renderer.depth().texture, 0u);
    seen(renderer, without, {});
    EXPECT_EQ(renderer.depth().texture, 0u);
}

/// A layer before it drew depth that it could not colour. A small view without depth must not take that for its own.
TEST_P(GlOtherSource, AfterAnotherLayerASmallViewWithoutDepthIsAskedByDirection) {
    const Frame frame = make_frame(0, flat, true);
    const auto changed = std::make_shared<ReceivedFrame>(*frame);
    ASSERT_TRUE(changed->small && changed->hidden);
    changed->small->depth_m = {};
    const double radius_m = head_box_radius(frame->main.info);
    const std::string passes = "hidden,small,pushpull";
    gl::EyeRenderer renderer(nullptr, radius_m, passes, GetParam());
    const auto found = seen(renderer, changed, {});
    OnTheCpu cpu(nullptr, radius_m, passes, std::string(GetParam()));
    const auto eyes = eyes_at(somewhere);
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        const EyePicture expected = cpu.see(*changed, *changed, eyes[i]);
        EXPECT_GT(psnr_db(found[i].rgba, expected.rgba), large_fills.min_db);
        EXPECT_LT(other_origins(found[i], expected), 0.002 * 320 * 200);
    }
}

/// As on the CPU, of another size, and one that shows another part of what is around: in what the mirror shows, too.
TEST_P(GlOtherSource, AnEarlierOneOfAnotherCameraFillsWhatTheCpuFills) {
    const Frame frame = make_frame(1, flat, true);
    const double radius_m = head_box_radius(frame->main.info);
    const std::string passes = "hidden,earlier,pushpull";
    const gl::RefreshOptions how{.mirrors = MirrorTreatment::gaps};
    const EquirectCamera part = window_camera({1024, 512, 256, 192}, {440, 150});
    for (const Camera& camera : {Camera(PerspectiveCamera{200, 126, flat.fov_x_rad}), Camera(part)}) {
        const Frame before = make_frame(0, camera, true);
        gl::EyeRenderer renderer(nullptr, radius_m, passes, GetParam());
        seen(renderer, before, how);
        const auto found = seen(renderer, frame, how);
        OnTheCpu cpu(nullptr, radius_m, passes, std::string(GetParam()));
        cpu.mirrors = how.mirrors;
        const auto eyes = eyes_at(somewhere);
        std::int64_t filled = 0;
        for (std::size_t i = 0; i < eyes.size(); ++i) {
            const EyePicture expected = cpu.see(*frame, *before, eyes[i]);
            EXPECT_GT(psnr_db(found[i].rgba, expected.rgba), large_fills.min_db);
            EXPECT_LT(other_origins(found[i], expected), 0.002 * 320 * 200);
            filled += found[i].count(PixelOrigin::earlier);
        }
        EXPECT_GT(filled, 100);
    }
}

INSTANTIATE_TEST_SUITE_P(By, GlOtherSource, testing::Values("mesh", "mesh-plain"), [](const auto& test) {
    std::string name(test.param);
    std::erase(name, '-');
    return name;
});

/// By the scene's geometry, by depth that came with the frame, of the window alone too, and without any: eyes turn
/// then.
enum class Known { geometry, depth, window_depth, nothing };
const std::string known_names[] = {"geometry", "depth", "window_depth", "nothing"};

class GlWindow : public GlEyeRenderer, public testing::WithParamInterface<Known> {
protected:
    static Streamed streamed() {
        return GetParam() == Known::depth          ? Streamed::all_depth
               : GetParam() == Known::window_depth ? Streamed::window_depth
                                                   : Streamed::nothing;
    }

    static std::array<EyePicture, 2> seen(gl::EyeRenderer& renderer, std::span<const Frame> frames,
                                          std::span<const EyeView> eyes) {
        gl::StageTimes times;
        gl::EyeTargets targets;
        for (const Frame& frame : frames) {
            renderer.show(frame, times);
            renderer.look(eyes, true, times);
            renderer.draw({.reliability = true}, targets, times);
        }
        std::array<EyePicture, 2> pictures;
        for (std::size_t i = 0; i < 2; ++i) {
            targets.download(int(i), pictures[i]);
            renderer.download_reliability(int(i), pictures[i]);
        }
        return pictures;
    }
    static const SceneDescription* geometry() { return GetParam() == Known::geometry ? &scene : nullptr; }
    static const char* engine() { return GetParam() == Known::nothing ? "rotation" : "mesh"; }
};

/// At rest, and turned so that a third of what the eyes see lies beyond the window; the frame before had it elsewhere,
/// or none.
TEST_P(GlWindow, ShowsWithTheSphereAroundWhatTheCpuShows) {
    // Outlines that the scene's geometry gives: of spheres they are drawn by other views than on the CPU.
    const Limits limits =
        geometry() == nullptr ? Limits{} : Limits{.other_reliabilities = 0.015, .other_origins = 0.003};
    const Frame frame = make_window_frame(1, 0, streamed());
    const double radius_m = head_box_radius(frame->main.info);
    for (const std::optional<int> before_right : {std::optional(3), std::optional<int>()})
        for (const glm::dquat& turn : {glm::dquat(1, 0, 0, 0), yaw_pitch(0.35, 0.1)}) {
            SCOPED_TRACE(testing::Message() << before_right.value_or(-1) << ' ' << turn.y);
            const std::array frames = {make_window_frame(0, before_right, streamed()), frame};
            const auto eyes = eyes_at({{0.01, 0.005, 0.01}, turn});
            gl::EyeRenderer renderer(geometry(), radius_m);
            const auto found = seen(renderer, frames, eyes);
            OnTheCpu cpu(geometry(), radius_m, default_fill, engine());
            for (std::size_t i = 0; i < eyes.size(); ++i) {
                SCOPED_TRACE(i);
                expect_same(found[i], cpu.see(*frame, *frames[0], eyes[i]), limits);
                EXPECT_TRUE(!before_right || found[i].count(PixelOrigin::base) > 320 * 200 / 10);
            }
        }
}

/// Eyes turn back to what it showed, and find it but where the sphere around has another colour by now. Eyes that know
/// no depth look nothing up in it.
TEST_P(GlWindow, ThatTheGazeHasLeftFillsWhatItFillsOnTheCpu) {
    const auto frame = std::make_shared<ReceivedFrame>(*make_window_frame(2, 0, streamed()));
    ByteImage& around = frame->base->rgb;
    for (int y = 0; y < around.height() / 2; ++y)
        for (std::uint8_t& sample : std::span(around.pixel(0, y), std::size_t(3 * around.width())))
            sample = std::uint8_t(std::min(sample + 60, 255));
    const std::array<Frame, 3> frames = {make_window_frame(0, 9, streamed()), make_window_frame(1, 0, streamed()),
                                         frame};
    const double radius_m = head_box_radius(frame->main.info);
    const auto eyes = eyes_at({{0.01, 0.005, 0.01}, yaw_pitch(0.5, 0)});
    gl::EyeRenderer renderer(geometry(), radius_m);
    const auto found = seen(renderer, frames, eyes);
    OnTheCpu cpu(geometry(), radius_m, default_fill, engine());
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        SCOPED_TRACE(i);
        const EyePicture expected = cpu.see(*frame, *frames[1], eyes[i], 0, frames[0].get());
        expect_same(found[i], expected, {.min_db = 45, .other_reliabilities = 0.03, .other_origins = 0.005});
        const auto earlier_in = [&](int top) {
            std::int64_t count = 0;
            for (int y = top; y < top + 100; ++y)
                for (int x = 0; x < 320; ++x)
                    count += *found[i].origin.pixel(x, y) == std::uint8_t(PixelOrigin::earlier);
            return count;
        };
        if (GetParam() == Known::nothing) {
            EXPECT_EQ(found[i].count(PixelOrigin::earlier), 0);
        } else {
            EXPECT_GT(earlier_in(100), 320 * 200 / 20);
            EXPECT_LT(earlier_in(0), earlier_in(100) / 5);
        }
    }
}

/// A window that no eye sees.
TEST_P(GlWindow, ShowsBeyondItWhatTheSphereAloneGives) {
    const Frame frame = make_window_frame(0, 25, streamed());
    const auto alone = std::make_shared<ReceivedFrame>();
    alone->main = *frame->base;
    const double radius_m = head_box_radius(frame->main.info);
    const auto eyes = eyes_at({{0.02, 0.005, 0.01}, {1, 0, 0, 0}});
    gl::EyeRenderer with_window(geometry(), radius_m), without(geometry(), radius_m);
    const auto found = seen(with_window, std::array<Frame, 1>{frame}, eyes),
               expected = seen(without, std::array<Frame, 1>{alone}, eyes);
    // By the scene's geometry a frame's main picture has its depth drawn by other views than its base.
    const auto [min_db, other_origins] =
        geometry() == nullptr ? std::pair(100.0, 0.0) : std::pair(Limits{}.min_db, 0.003 * 320 * 200);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_GT(psnr_db(found[i].rgba, expected[i].rgba), min_db);
        EXPECT_NEAR(double(found[i].count(PixelOrigin::base)), double(expected[i].count(PixelOrigin::source)),
                    other_origins);
        EXPECT_EQ(found[i].count(PixelOrigin::source), 0);
    }
}

/// Of eyes that look into the middle of the window nothing of the sphere around is drawn, nor looked up.
TEST_P(GlWindow, LeavesTheSphereAloneWhereItIsNotSeen) {
    gl::EyeRenderer renderer(geometry(), head_box_radius(make_window_frame(0, 0, streamed())->main.info));
    gl::StageTimes times;
    gl::EyeTargets targets;
    renderer.show(make_window_frame(0, 0, streamed()), times);
    GLuint name = 0;
    glCreateQueries(GL_PRIMITIVES_GENERATED, 1, &name);
    const gl::Query drawn(name);
    const auto primitives = [&](double fov_x_rad) {
        auto eyes = eyes_at({{0.01, 0.005, 0.01}, {1, 0, 0, 0}});
        for (EyeView& eye : eyes)
            eye.camera.fov_x_rad = fov_x_rad;
        GLuint count = 0;
        // The first time something is made.
        for (int i = 0; i < 2; ++i) {
            renderer.look(eyes, true, times);
            glBeginQuery(GL_PRIMITIVES_GENERATED, name);
            renderer.draw({}, targets, times);
            glEndQuery(GL_PRIMITIVES_GENERATED);
            glGetQueryObjectuiv(name, GL_QUERY_RESULT, &count);
            EyePicture picture;
            targets.download(0, picture);
            EXPECT_EQ(picture.count(PixelOrigin::base) > 0, fov_x_rad > 1);
        }
        return count;
    };
    const GLuint of_window = primitives(0.5);
    EXPECT_EQ(of_window, 2u) << "what covers each eye's picture";
    EXPECT_GT(primitives(pi / 2), of_window + 2);
    EXPECT_EQ(primitives(0.5), of_window);
}

/// Once all was drawn, while the window stays: a mesh is made anew where it moves.
TEST_P(GlWindow, MakesNothingAnew) {
    std::vector<Frame> frames = {make_window_frame(0, 0, streamed()), make_window_frame(1, 0, streamed())};
    for (std::int64_t index = 2; index < 8; ++index) {
        const auto later = std::make_shared<ReceivedFrame>(*frames[std::size_t(index % 2)]);
        later->main.info.index = index;
        later->main.info.time_s = double(index) / 30;
        frames.push_back(later);
    }
    gl::EyeRenderer renderer(geometry(), head_box_radius(frames[0]->main.info));
    gl::StageTimes times;
    gl::EyeTargets targets;
    const auto eyes = eyes_at({{0.01, 0.005, 0.01}, yaw_pitch(0.35, 0.1)});
    const auto walk = [&](std::size_t from, std::size_t to) {
        for (std::size_t i = from; i < to; ++i) {
            renderer.show(frames[i], times);
            renderer.look(eyes, true, times);
            renderer.draw({.reliability = true}, targets, times);
        }
    };
    walk(0, 6);
    const MadeObjects made;
    const CountedMemory memory;
    walk(6, 8);
    EXPECT_EQ(memory.allocations(), 0);
    EXPECT_EQ(made.count(), 0);
}

/// Frame after frame with a window, without and with one again.
TEST_P(GlWindow, ComesAndGoes) {
    const std::array frames = {make_window_frame(0, 0, streamed()), make_window_frame(1, {}, streamed()),
                               make_window_frame(2, 2, streamed()), make_window_frame(3, {}, streamed())};
    const double radius_m = head_box_radius(frames[0]->main.info);
    const auto eyes = eyes_at({{0.01, 0.005, 0.01}, yaw_pitch(0.2, 0)});
    const std::string passes = "base,pushpull";
    gl::EyeRenderer renderer(geometry(), radius_m, passes);
    for (const Frame& frame : frames) {
        SCOPED_TRACE(frame->main.info.index);
        gl::EyeRenderer alone(geometry(), radius_m, passes);
        const auto found = seen(renderer, {&frame, 1}, eyes), expected = seen(alone, {&frame, 1}, eyes);
        for (std::size_t i = 0; i < 2; ++i) {
            // The mesh of a picture after one of another size is not the same to the last bit.
            EXPECT_GT(psnr_db(found[i].rgba, expected[i].rgba), 75);
            EXPECT_EQ(other_origins(found[i], expected[i]), 0);
            EXPECT_EQ(found[i].count(PixelOrigin::base) > 0, frame->base.has_value());
        }
    }
}

/// What was blurred beyond it meets the window without a step: none larger than between other neighbours, right of the
/// ball, behind which the sphere fills gaps too.
TEST_P(GlWindow, HasNoBorderThatIsSeen) {
    const auto frame = std::make_shared<ReceivedFrame>(*make_window_frame(0, 0, streamed()));
    const Pose pose = frame->main.info.camera_pose;
    const auto paint = [&](ReceivedPicture& picture, double contrast) {
        const auto colour = [&](const glm::dvec3& p, double) {
            return 0.5 + contrast * (smooth(glm::normalize(p - pose.position_m), 6) - 0.5);
        };
        picture.rgb = render(ball_and_wall, colour, picture.info.camera, pose).rgb;
    };
    frame->main.specular = frame->main.virtual_depth_m = {};
    paint(frame->main, 1);
    paint(*frame->base, 0.6);
    const std::array<Frame, 1> frames = {frame};
    const auto eyes = eyes_at({pose.position_m, yaw_pitch(0.3, 0.1)});
    gl::EyeRenderer renderer(geometry(), head_box_radius(frame->main.info), "base");
    int across = 0, elsewhere = 0;
    for (const EyePicture& picture : seen(renderer, frames, eyes))
        for (int y = 0; y + 1 < 200; ++y)
            for (int x = 160; x + 1 < 320; ++x)
                for (const auto& [right, below] : {std::pair(x + 1, y), std::pair(x, y + 1)}) {
                    const auto a = PixelOrigin{*picture.origin.pixel(x, y)},
                               b = PixelOrigin{*picture.origin.pixel(right, below)};
                    int& largest = a == b ? elsewhere : across;
                    for (int c = 0; c < 3; ++c)
                        largest = std::max(largest,
                                           std::abs(picture.rgba.pixel(x, y)[c] - picture.rgba.pixel(right, below)[c]));
                }
    EXPECT_LE(across, elsewhere);
    EXPECT_LE(elsewhere, 8);
}

INSTANTIATE_TEST_SUITE_P(By, GlWindow,
                         testing::Values(Known::geometry, Known::depth, Known::window_depth, Known::nothing),
                         [](const auto& test) { return known_names[int(test.param)]; });

}  // namespace
}  // namespace equistream::test
