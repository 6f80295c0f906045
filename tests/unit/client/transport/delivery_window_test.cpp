/// How much may be on its way, on a line that is made up here.
#include <client/transport/delivery_window.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace equistream::test {
namespace {

/// Bytes that are written as the window lets them, carried at a rate, and acknowledged a round trip later.
class MadeUpLine {
public:
    double bytes_per_second = 1e6, round_trip_s = 0.05;
    double asked_bytes_per_second = 1e12;  // what there is to write
    DeliveryWindow window;
    double time_s = 0;

    void run(double until_s) {
        constexpr double step_s = 0.01;
        for (; time_s < until_s; time_s += step_s) {
            written_ = std::clamp(written_ + asked_bytes_per_second * step_s, written_,
                                  std::max(written_, delivered_ + double(window.bytes())));
            at_far_end_.push_back(
                std::min(written_, (at_far_end_.empty() ? 0 : at_far_end_.back()) + bytes_per_second * step_s));
            const auto steps_back = std::size_t(round_trip_s / step_s);
            delivered_ = at_far_end_.size() > steps_back ? at_far_end_[at_far_end_.size() - 1 - steps_back] : 0;
            window.add(time_s, written_, delivered_, written_ - delivered_ >= double(window.bytes()));
        }
    }

    /// Nothing is written and nobody looks.
    void pause(double duration_s) {
        for (double end_s = time_s + duration_s; time_s < end_s; time_s += 0.01)
            at_far_end_.push_back(std::min(written_, at_far_end_.back() + bytes_per_second * 0.01));
    }

private:
    double written_ = 0, delivered_ = 0;
    std::vector<double> at_far_end_;  // at each step
};

TEST(DeliveryWindow, IsTwiceWhatTheLineTakesInARoundTrip) {
    MadeUpLine line;
    line.bytes_per_second = 5e6;
    line.run(5);
    EXPECT_NEAR(line.window.bytes_per_second(), 5e6, 0.05 * 5e6);
    EXPECT_NEAR(double(line.window.bytes()), 2 * 5e6 * 0.06, 0.3 * 2 * 5e6 * 0.06);
}

TEST(DeliveryWindow, FollowsALineThatHasLessRoom) {
    MadeUpLine line;
    line.bytes_per_second = 1e7;
    line.run(3);
    const auto before = line.window.bytes();
    line.bytes_per_second = 1e6;
    line.run(20);
    EXPECT_LT(double(line.window.bytes()), 0.3 * double(before));
    EXPECT_NEAR(line.window.bytes_per_second(), 1e6, 0.05 * 1e6);
    line.bytes_per_second = 1e7;
    line.run(25);
    EXPECT_GT(line.window.bytes_per_second(), 9e6);
}

TEST(DeliveryWindow, RemembersTheLineWhileLittleIsWritten) {
    MadeUpLine line;
    line.bytes_per_second = 1e7;
    line.run(3);
    line.asked_bytes_per_second = 1e5;
    line.run(8);
    EXPECT_NEAR(line.window.bytes_per_second(), 1e7, 0.05 * 1e7);
}

TEST(DeliveryWindow, RemembersTheLineAcrossPausesAndDrains) {
    MadeUpLine line;
    line.bytes_per_second = 1e7;
    line.run(3);
    line.pause(3);
    line.run(6.05);
    EXPECT_GT(line.window.bytes_per_second(), 9e6) << "a burst after a pause";
    line.asked_bytes_per_second = 3e6;  // 150 kB are on their way
    line.run(30);
    EXPECT_GT(line.window.bytes_per_second(), 9e6);
}

TEST(DeliveryWindow, SeesAQueueThatIsNotItsWindow) {
    MadeUpLine line;
    line.bytes_per_second = 2e7;
    line.run(3);
    line.bytes_per_second = 1e6;
    line.asked_bytes_per_second = 1.2e6;
    line.run(8);
    EXPECT_LT(line.window.bytes_per_second(), 1.3e6);
}

/// Its own bytes wait in a queue from the first on, so that no acknowledgement shows the line alone until it is
/// drained.
TEST(DeliveryWindow, SeesTheLineAloneFromTimeToTime) {
    MadeUpLine line;
    line.bytes_per_second = 1e5;
    line.round_trip_s = 0.1;
    line.run(1);
    line.round_trip_s = 0.3;  // another way
    line.run(30);
    EXPECT_NEAR(line.window.acknowledged_after_s(), 0.3 + 65536 / 1e5, 0.5);
    EXPECT_GT(line.window.acknowledged_after_s(), 0.25);
}

TEST(DeliveryWindow, IsBounded) {
    DeliveryWindow window;
    EXPECT_EQ(window.bytes(), 65536u);
    for (int i = 0; i < 100; ++i)
        window.add(0.01 * i, 1000 * i, 1000 * i, true);
    EXPECT_EQ(window.bytes(), 65536u);
    for (int i = 100; i < 200; ++i)
        window.add(0.01 * i, 1e8 * i, 1e8 * (i - 10), true);
    EXPECT_EQ(window.bytes(), std::size_t{8} << 20);
}

}  // namespace
}  // namespace equistream::test
