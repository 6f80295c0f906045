/// Around what a head is moved whose movements come back as frames, late.
#include <client/playback/playback.h>

#include <gtest/gtest.h>

#include <deque>

namespace equistream {
namespace {

Pose at(double x) {
    return {{x, 1.6, -2}, {1, 0, 0, 0}};
}

TEST(FollowedHead, IsAroundEachFramesHeadWhileNobodyFollows) {
    FollowedHead head;
    for (const double x : {0.0, 0.5, -2.0}) {
        head.show(at(x));
        EXPECT_FALSE(head.is_followed());
        EXPECT_EQ(head.around().position_m.x, x);
        head.sent(at(x + 0.1));  // to somebody who does not care
    }
}

/// A server that renders three frames late what it was told last.
TEST(FollowedHead, DoesNotAddUpWhatComesBack) {
    FollowedHead head;
    std::deque<Pose> on_their_way(3, at(5));
    for (int frame = 0; frame < 40; ++frame) {
        head.show(on_their_way.front());
        on_their_way.pop_front();
        const double offset_m = 0.1 * std::min(frame, 10);
        Pose moved = head.around();
        moved.position_m.x += offset_m;
        EXPECT_NEAR(moved.position_m.x, 5 + offset_m, 1e-12) << frame;
        if (offset_m > 0)
            head.sent(moved);
        on_their_way.push_back(moved);
        EXPECT_EQ(head.is_followed(), frame > 3) << frame;
    }
}

TEST(FollowedHead, GoesWithTheFramesAgainWhenAnotherSteers) {
    FollowedHead head;
    head.show(at(0));
    head.sent(at(0.3));
    head.show(at(0.3));
    EXPECT_TRUE(head.is_followed());
    EXPECT_EQ(head.around().position_m.x, 0);
    head.show(at(7));
    EXPECT_FALSE(head.is_followed());
    EXPECT_EQ(head.around().position_m.x, 7);
}

}  // namespace
}  // namespace equistream
