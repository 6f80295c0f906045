#include <client/view/input_box.h>

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace equistream::test {
namespace {

TakenInputs pressed(Action action, double time_s) {
    TakenInputs inputs;
    inputs.samples.emplace_back().time_s = time_s;
    inputs.pressed.push_back(action);
    inputs.scroll = 0.5;
    inputs.any = true;
    inputs.window = {320, 180};
    return inputs;
}

TEST(InputBox, HandsOverOnceAndInOrder) {
    InputBox box;
    box.put(pressed(Action::times, 1));
    TakenInputs second = pressed(Action::help, 2);
    second.click_x = 0.25;
    second.window = {100, 50};
    box.put(second);
    TakenInputs taken;
    box.take(taken);
    EXPECT_EQ(taken.pressed, (std::vector{Action::times, Action::help}));
    ASSERT_EQ(taken.samples.size(), 2U);
    EXPECT_EQ(taken.samples[1].time_s, 2);
    EXPECT_EQ(taken.scroll, 1);
    EXPECT_EQ(taken.click_x, 0.25);
    EXPECT_EQ(taken.window, (gl::Size{100, 50}));
    EXPECT_TRUE(taken.any);
    box.take(taken);
    EXPECT_FALSE(taken.any);
    EXPECT_TRUE(taken.pressed.empty());
    EXPECT_TRUE(taken.samples.empty());
    EXPECT_EQ(taken.scroll, 0);
    EXPECT_LT(taken.click_x, 0);
    EXPECT_EQ(taken.window, (gl::Size{100, 50})) << "states stay";
}

TEST(InputBox, RequestsCountOnce) {
    InputBox box;
    EXPECT_FALSE(box.take_fullscreen_toggle());
    box.ask_for_fullscreen_toggle();
    EXPECT_TRUE(box.take_fullscreen_toggle());
    EXPECT_FALSE(box.take_fullscreen_toggle());
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
            TakenInputs inputs = pressed(Action::times, i);
            inputs.is_closed = i == count - 1;
            box.put(inputs);
        }
        while (!box.is_over())
            std::this_thread::yield();
    });
    TakenInputs taken;
    double scrolled = 0, next = 0;
    std::size_t presses = 0;
    while (!taken.is_closed) {
        box.wait(60);
        box.take(taken);
        for (const InputSample& sample : taken.samples)
            EXPECT_EQ(sample.time_s, next++);
        presses += taken.pressed.size();
        taken_so_far = int(next);
        scrolled += taken.scroll;
    }
    box.end();
    telling.join();
    EXPECT_EQ(next, count);
    EXPECT_EQ(presses, std::size_t(count));
    EXPECT_EQ(scrolled, 0.5 * count);
}

}  // namespace
}  // namespace equistream::test
