#include <equistream/conventions.h>

#include <client/view/head_motion.h>
#include <client/view/input_box.h>

#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

#include <atomic>
#include <initializer_list>
#include <thread>

namespace equistream::test {
namespace {

Steering holding(std::initializer_list<Action> actions) {
    Steering steering;
    for (const Action action : actions)
        steering.held.set(std::size_t(action));
    return steering;
}

/// So long, in refreshes of that length.
void hold(Navigator& navigator, const Steering& steering, double seconds, double refresh_s) {
    for (double t = 0; t < seconds - 1e-9; t += refresh_s)
        navigator.steer(steering, refresh_s);
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
    EXPECT_LT(glm::distance(a, b), tolerance) << a.x << ' ' << a.y << ' ' << a.z;
}

TEST(Navigator, TurnsAtItsSpeedWhateverTheRefreshRate) {
    for (const double refresh_s : {1 / 240.0, 1 / 60.0, 0.1}) {
        Navigator navigator;
        hold(navigator, holding({Action::turn_left, Action::turn_up}), 1, refresh_s);
        EXPECT_NEAR(navigator.yaw_rad(), Navigator::turn_rad_per_s, 1e-6);
        EXPECT_NEAR(navigator.pitch_rad(), Navigator::turn_rad_per_s, 1e-6);
    }
}

/// Left is +X's other side: the head then looks along -X.
TEST(Navigator, LeftAndUpAreWhereTheyShouldBe) {
    Navigator navigator;
    Steering drag;
    drag.drag_yaw_rad = pi / 2;
    navigator.steer(drag, 0);
    expect_near(navigator.head({}).orientation * glm::dvec3(0, 0, -1), {-1, 0, 0}, 1e-12);
    drag = {};
    drag.drag_pitch_rad = pi / 4;
    navigator.steer(drag, 0);
    expect_near(navigator.head({}).orientation * glm::dvec3(0, 0, -1), {-std::sqrt(0.5), std::sqrt(0.5), 0}, 1e-12);
}

TEST(Navigator, NobodyLooksOverTheTop) {
    Navigator navigator;
    hold(navigator, holding({Action::turn_down}), 10, 0.1);
    EXPECT_DOUBLE_EQ(navigator.pitch_rad(), -pi / 2);
    hold(navigator, holding({Action::turn_left}), 10, 0.1);
    EXPECT_LE(std::abs(navigator.yaw_rad()), pi);
}

TEST(Navigator, MovesWhereItLooksOnTheLevelAndStartsSoftly) {
    Navigator navigator;
    Steering drag;
    drag.drag_yaw_rad = pi / 2;
    drag.drag_pitch_rad = 1;
    navigator.steer(drag, 0);
    hold(navigator, holding({Action::move_forward}), 1, 1e-3);
    // Full speed but for the soft start, of which half is lost.
    const double way = Navigator::move_m_per_s * (1 - Navigator::soft_start_s / 2);
    expect_near(navigator.offset_m(), {-way, 0, 0}, 1e-3 * way);
    const glm::dvec3 there = navigator.offset_m();
    hold(navigator, {}, 1, 1e-3);
    EXPECT_LT(glm::distance(navigator.offset_m(), there), Navigator::move_m_per_s * Navigator::soft_start_s);
}

TEST(Navigator, SticksDoWhatKeysDo) {
    Navigator keys, sticks;
    Steering steering;
    steering.turn_x = steering.turn_y = -1;
    steering.move_x = steering.move_y = 1;
    steering.move_z = -1;
    hold(keys, holding({Action::turn_left, Action::turn_up, Action::move_right, Action::move_up, Action::move_forward}),
         0.5, 0.01);
    hold(sticks, steering, 0.5, 0.01);
    EXPECT_NEAR(keys.yaw_rad(), sticks.yaw_rad(), 1e-12);
    EXPECT_NEAR(keys.pitch_rad(), sticks.pitch_rad(), 1e-12);
    expect_near(keys.offset_m(), sticks.offset_m(), 1e-12);
}

/// Where a frame's own head is turned, so is what the viewer adds to it.
TEST(Navigator, GoesAlongWithTheFramesHead) {
    Navigator navigator;
    hold(navigator, holding({Action::move_right}), 1, 0.01);
    const Pose around{{1, 2, 3}, glm::angleAxis(pi / 2, glm::dvec3(0, 1, 0))};
    const Pose head = navigator.head(around);
    expect_near(head.position_m - around.position_m, {0, 0, -navigator.offset_m().x}, 1e-12);
    navigator.centre();
    EXPECT_EQ(navigator.head(around).position_m, around.position_m);
}

TEST(HeadBoxFading, IsNothingWithinAndAllFarOutside) {
    EXPECT_EQ(head_box_fading(0.1, 0.13), 0);
    EXPECT_EQ(head_box_fading(0.13, 0.13), 0);
    EXPECT_NEAR(head_box_fading(0.13 + 0.125, 0.13), 0.5, 1e-12);
    EXPECT_EQ(head_box_fading(0.5, 0.13), 1);
    EXPECT_NEAR(head_box_fading(2.5, 2), 0.5, 1e-12);
}

}  // namespace

namespace {

WindowInputs scrolled(double steps) {
    WindowInputs inputs;
    inputs.events = {WheelEvent{steps}};
    inputs.any = true;
    inputs.window = {320, 180};
    return inputs;
}

double steps_of(const InputEvent& event) {
    return std::get<WheelEvent>(event).steps;
}

TEST(InputBox, HandsOverOnceAndInOrder) {
    InputBox box;
    box.put(scrolled(1));
    WindowInputs second = scrolled(2);
    second.window = {100, 50};
    second.scale = 1.5;
    box.put(second);
    WindowInputs taken;
    box.take(taken);
    ASSERT_EQ(taken.events.size(), 2U);
    EXPECT_EQ(steps_of(taken.events[0]), 1);
    EXPECT_EQ(steps_of(taken.events[1]), 2);
    EXPECT_EQ(taken.window, (gl::Size{100, 50}));
    EXPECT_TRUE(taken.any);
    box.take(taken);
    EXPECT_FALSE(taken.any);
    EXPECT_TRUE(taken.events.empty());
    EXPECT_EQ(taken.window, (gl::Size{100, 50})) << "states stay";
    EXPECT_EQ(taken.scale, 1.5);
    box.wake();
    box.wait(60);
    box.take(taken);
    EXPECT_TRUE(taken.any);
}

TEST(InputBox, RequestsCountOnce) {
    InputBox box;
    EXPECT_FALSE(box.take_fullscreen_toggle());
    box.ask_for_fullscreen_toggle();
    EXPECT_TRUE(box.take_fullscreen_toggle());
    EXPECT_FALSE(box.take_fullscreen_toggle());
    EXPECT_FALSE(box.take_title());
    box.ask_for_title("one");
    box.ask_for_title("two");
    EXPECT_EQ(box.take_title(), "two");
    EXPECT_FALSE(box.take_title());
    KeptSettings kept;
    kept.recent = {"/a"};
    box.ask_to_keep(kept);
    EXPECT_EQ(box.take_kept(), kept);
    EXPECT_FALSE(box.take_kept());
    EXPECT_FALSE(box.is_over());
    box.end();
    EXPECT_TRUE(box.is_over());
}

/// Two threads as in the viewer: nothing is lost, doubled or out of order, and who waits is woken.
TEST(InputBox, TwoThreadsLoseNothing) {
    constexpr int count = 2000;
    constexpr int max_ahead = 50;  // neither does all of its work before the other begins
    InputBox box;
    std::atomic<int> taken_so_far = 0;
    std::thread telling([&] {
        for (int i = 0; i < count; ++i) {
            while (i > taken_so_far + max_ahead)
                std::this_thread::yield();
            WindowInputs inputs = scrolled(i);
            inputs.is_closed = i == count - 1;
            box.put(inputs);
        }
        while (!box.is_over())
            std::this_thread::yield();
    });
    WindowInputs taken;
    double next = 0;
    while (!taken.is_closed) {
        box.wait(60);
        box.take(taken);
        for (const InputEvent& event : taken.events)
            EXPECT_EQ(steps_of(event), next++);
        taken_so_far = int(next);
    }
    box.end();
    telling.join();
    EXPECT_EQ(next, count);
}

}  // namespace
}  // namespace equistream::test
