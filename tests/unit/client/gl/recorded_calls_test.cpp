/// A viewer's refreshes by the calls that reach the driver: nothing is made after the first ones, and both eyes cost as
/// many draws as one. Wrong calls end the program (gl_fixture.h).
#include "gl_fixture.h"
#include "recorded_calls.h"

#include <client/view/gl/display.h>
#include <client/view/gl/eye_renderer.h>
#include <tests/unit/client/fill_scene.h>
#include <tests/unit/scenes/generate/scratch_folder.h>

#include <client/receive/receive.h>
#include <equistream/colour.h>

#include <array>
#include <fstream>
#include <memory>

namespace equistream::test {
namespace {

constexpr gl::Size window{320, 200};

/// A wall that eyes see past the ball, which is in no geometry.
std::shared_ptr<const ReceivedFrame> make_frame(std::int64_t index) {
    const Pose pose{{-0.0315 - 0.01 * double(index), 0, 0}, {1, 0, 0, 0}};
    const Rendered rendered = render(ball_and_wall, red_and_smooth, EquirectCamera{128, 64, {}}, pose);
    auto frame = std::make_shared<ReceivedFrame>();
    frame->main.info.index = index;
    frame->main.info.time_s = double(index) / 30;
    frame->main.info.camera = rendered.camera;
    frame->main.info.camera_pose = frame->main.info.head = pose;
    frame->main.rgb = rendered.rgb;
    return frame;
}

std::array<EyeView, 2> eyes_at(double t) {
    const PerspectiveCamera camera{window.width / 2, window.height, pi / 2};
    const glm::dquat turned = glm::angleAxis(2 * t, glm::dvec3(0, 1, 0));
    return {EyeView{camera, {{-0.0315 + 0.1 * t, 0, 0}, turned}}, EyeView{camera, {{0.0315 + 0.1 * t, 0, 0}, turned}}};
}

class GlRecordedCalls : public Gl {
protected:
    GlRecordedCalls() {
        scene_.file = scene_.model = folder_ / "wall.obj";
        std::ofstream(scene_.model) << "v -60 -60 -3\nv 60 -60 -3\nv 60 60 -3\nv -60 60 -3\nf 1 2 3 4\n";
        for (std::int64_t i = 0; i < 4; ++i)
            frames_.push_back(make_frame(i));
        renderer_ = std::make_unique<gl::EyeRenderer>(&scene_, head_box_radius(frames_[0]->main.info),
                                                      "hidden,patches,earlier,pushpull");
        display_ = std::make_unique<gl::Display>();
        picture_ = gl::make_texture(window, GL_RGBA8);
        GLuint name = 0;
        glCreateFramebuffers(1, &name);
        framebuffer_ = gl::Framebuffer(name);
        glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, picture_.name(), 0);
    }

    void refresh(std::int64_t frame, std::size_t eyes, bool surface = true) {
        times_.start(false);
        renderer_->show(frames_[std::size_t(frame)], times_);
        const auto views = eyes_at(double(frame) / 30);
        renderer_->look(std::span(views).first(eyes), surface, times_);
        renderer_->draw({.surface = surface, .reliability = true}, targets_, times_);
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        display_->draw({.eyes = &targets_, .depth = renderer_->depth(), .source = &renderer_->source()},
                       {.layout = eyes == 2 ? gl::DisplayLayout::side_by_side : gl::DisplayLayout::left}, window);
    }

    const ScratchFolder folder_{"recorded-calls"};
    SceneDescription scene_;
    std::vector<std::shared_ptr<const ReceivedFrame>> frames_;
    std::unique_ptr<gl::EyeRenderer> renderer_;
    std::unique_ptr<gl::Display> display_;
    gl::Texture picture_;
    gl::Framebuffer framebuffer_;
    gl::EyeTargets targets_;
    gl::StageTimes times_;
};

TEST_F(GlRecordedCalls, NothingIsMadeAfterTheFirstRefreshes) {
    RecordedCalls calls;
    for (const bool surface : {true, false})
        for (std::int64_t i = 0; i < 4; ++i)
            refresh(i, 2, surface);
    EXPECT_GT(calls.made(), 0) << "the first refreshes make what they need";
    calls.forget();
    for (const bool surface : {true, false})
        for (std::int64_t i = 0; i < 4; ++i)
            refresh(i, 2, surface);
    EXPECT_EQ(calls.made(), 0) << calls.all().size() << " calls";
    EXPECT_GT(calls.draws(), 0);
    EXPECT_GT(calls.dispatches(), 0);
}

TEST_F(GlRecordedCalls, EveryRefreshCallsTheSame) {
    RecordedCalls calls;
    refresh(0, 2);
    refresh(1, 2);
    calls.forget();
    refresh(2, 2);
    const auto first = calls.all();
    calls.forget();
    refresh(3, 2);
    EXPECT_EQ(calls.all(), first);
}

/// Layers of one pass: a draw of geometry for all views of both eyes, one more for the window.
TEST_F(GlRecordedCalls, TwoEyesTakeAsManyDrawsAsOne) {
    RecordedCalls calls;
    std::array<std::ptrdiff_t, 3> draws{}, dispatches{};
    for (const std::size_t eyes : {1, 2}) {
        refresh(0, eyes);
        refresh(1, eyes);
        calls.forget();
        refresh(2, eyes);
        draws[eyes] = calls.draws();
        dispatches[eyes] = calls.dispatches();
    }
    EXPECT_EQ(draws[2], draws[1]);
    EXPECT_EQ(dispatches[2], dispatches[1]);
    EXPECT_LE(draws[2], 5);
}

}  // namespace
}  // namespace equistream::test
