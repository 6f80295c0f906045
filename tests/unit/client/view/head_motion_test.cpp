#include <client/playback/playback.h>
#include <client/view/head_motion.h>

#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <initializer_list>

namespace equistream::test {
namespace {

Steering holding(std::initializer_list<Action> actions) {
    Steering steering;
    for (const Action action : actions)
        steering.held.set(std::size_t(action));
    return steering;
}

/// Samples as a mouse or a refresh brings them, so many a second.
void steer(HeadMotion& motion, const Steering& steering, double from_s, double to_s, double hz) {
    for (double t = from_s; t < to_s - 1e-9; t += 1 / hz)
        motion.steer(steering, t + 1 / hz);
}

double angle_rad(const Pose& a, const Pose& b) {
    return 2 * std::acos(std::min(1.0, std::abs(glm::dot(a.orientation, b.orientation))));
}

TEST(HeadMotion, ATurnIsForetoldForWhenItIsSeen) {
    for (const double hz : {60.0, 90.0, 500.0}) {
        HeadMotion motion;
        motion.steer({}, 10);
        steer(motion, holding({Action::turn_left}), 10, 10.5, hz);
        for (const double ahead_s : {0.01, 0.03, 0.1}) {
            const Pose expected{{}, glm::angleAxis((0.5 + ahead_s) * Navigator::turn_rad_per_s, glm::dvec3(0, 1, 0))};
            EXPECT_NEAR(angle_rad(motion.predict(ahead_s), expected), 0, 1e-6) << hz << ' ' << ahead_s;
        }
        EXPECT_NEAR(angle_rad(motion.predict(0), motion.head()), 0, 1e-12);
        EXPECT_NEAR(motion.navigator().yaw_rad(), 0.5, 1e-6);
    }
}

TEST(HeadMotion, AKeyHeldThroughAPauseTurnsNoFurther) {
    HeadMotion motion;
    motion.steer({}, 0);
    motion.steer(holding({Action::turn_left}), 60);
    EXPECT_NEAR(motion.navigator().yaw_rad(), 0.25 * Navigator::turn_rad_per_s, 1e-9);
}

TEST(HeadMotion, LooksAsAnotherOneWhoseClockIsAnother) {
    Steering steering;
    steering.drag_yaw_rad = 0.7;
    steering.drag_pitch_rad = -0.2;
    HeadMotion before, motion;
    before.steer({}, 100);
    before.steer(steering, 100.01);
    motion.look_as(before);
    EXPECT_NEAR(angle_rad(motion.head(), before.head()), 0, 1e-7);
    motion.steer({}, 3);
    EXPECT_TRUE(motion.is_resting());
    EXPECT_EQ(motion.predict(0.05).orientation, before.head().orientation);
}

TEST(HeadMotion, AMoveIsForetold) {
    HeadMotion motion;
    motion.steer({}, 0);
    steer(motion, holding({Action::move_right}), 0, 1, 90);
    const double ahead_s = 0.05;
    EXPECT_NEAR(motion.predict(ahead_s).position_m.x - motion.head().position_m.x, ahead_s * Navigator::move_m_per_s,
                1e-6);
}

/// What rests is where it is, to the last bit: a still view is not drawn again.
TEST(HeadMotion, WhatRestsIsExactlyWhereItIs) {
    HeadMotion motion;
    EXPECT_TRUE(motion.is_resting());
    motion.steer({}, 0);
    EXPECT_TRUE(motion.is_resting());
    steer(motion, holding({Action::turn_up, Action::turn_right}), 0, 0.3, 90);
    EXPECT_FALSE(motion.is_resting());
    EXPECT_GT(angle_rad(motion.predict(0.05), motion.head()), 0.01);
    motion.steer({}, 0.5 + 1e-3);
    EXPECT_TRUE(motion.is_resting());
    EXPECT_EQ(motion.predict(0.05).orientation, motion.head().orientation);
    EXPECT_EQ(motion.predict(0.05).position_m, motion.head().position_m);
}

/// After a stop it comes to rest without going far beyond.
TEST(HeadMotion, AStopIsSoonForetoldToo) {
    HeadMotion motion;
    motion.steer({}, 0);
    steer(motion, holding({Action::turn_left}), 0, 0.5, 90);
    const Pose stopped = motion.head();
    double farthest_rad = 0;
    for (int i = 1; i <= 20; ++i) {
        motion.steer({}, 0.5 + i / 90.0);
        farthest_rad = std::max(farthest_rad, angle_rad(motion.predict(0.03), stopped));
    }
    EXPECT_LT(farthest_rad, 1.1 * 0.03 * Navigator::turn_rad_per_s);
    EXPECT_NEAR(angle_rad(motion.predict(0.03), stopped), 0, 1e-12);
}

TEST(HeadMotion, BackToTheMiddleIsNoMotion) {
    HeadMotion motion;
    motion.steer({}, 0);
    steer(motion, holding({Action::turn_left, Action::move_forward}), 0, 0.5, 90);
    motion.centre();
    EXPECT_NEAR(angle_rad(motion.predict(0.1), {}), 0, 1e-12);
    motion.steer({}, 0.52);
    EXPECT_NEAR(angle_rad(motion.predict(0.1), {}), 0, 1e-12);
    EXPECT_EQ(motion.head().position_m, glm::dvec3(0));
}

/// In whatever head's axes: a turned head's forward is where it looks.
TEST(HeadMotion, PosesComposeAsTheNavigatorHasThem) {
    Navigator navigator;
    Steering drag;
    drag.drag_yaw_rad = 0.7;
    drag.drag_pitch_rad = -0.3;
    navigator.steer(drag, 0);
    for (int i = 0; i < 50; ++i)
        navigator.steer(holding({Action::move_forward, Action::move_up}), 0.02);
    const Pose around{{1, 2, 3}, glm::angleAxis(2.0, glm::normalize(glm::dvec3(1, 2, -1)))};
    const Pose expected = navigator.head(around), found = composed(around, navigator.head({}));
    EXPECT_LT(glm::distance(found.position_m, expected.position_m), 1e-12);
    EXPECT_NEAR(angle_rad(found, expected), 0, 1e-7);
    EXPECT_GT(glm::distance(found.position_m, around.position_m), 0.1);
}

TEST(DisplayLatency, IsAnAverageOfTheLast) {
    DisplayLatency latency;
    EXPECT_EQ(latency.seconds(), 0);
    latency.measured(0.02);
    EXPECT_EQ(latency.seconds(), 0.02);
    for (int i = 0; i < 100; ++i)
        latency.measured(i % 2 == 0 ? 0.01 : 0.03);
    EXPECT_NEAR(latency.seconds(), 0.02, 0.002);
}

TEST(HeadInWords, IsWhereItLooksAndWhereItIs) {
    EXPECT_EQ(in_words(Pose{}), "yaw 0 pitch 0 deg, head 0 0 0 cm");
    const auto turned = [](double yaw_deg, double pitch_deg) {
        return glm::angleAxis(glm::radians(yaw_deg), glm::dvec3(0, 1, 0)) *
               glm::angleAxis(glm::radians(pitch_deg), glm::dvec3(1, 0, 0));
    };
    EXPECT_EQ(in_words({{0.1, -0.204, 0.351}, turned(30, -20)}), "yaw 30 pitch -20 deg, head 10 -20 35 cm");
    EXPECT_EQ(in_words({{-0.001, 0, 0}, turned(-70, 90)}), "yaw -70 pitch 90 deg, head 0 0 0 cm");
}

}  // namespace
}  // namespace equistream::test

// Around what a head is moved whose movements come back as frames, late.

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

/// A recording whose head stands and turns, watched by a viewer who stands there too and looks elsewhere.
TEST(FollowedHead, GoesWithFramesThatOnlyTurn) {
    FollowedHead head;
    for (const double yaw_rad : {0.0, 0.2, 0.4}) {
        const Pose turned = {at(1).position_m, glm::angleAxis(yaw_rad, glm::dvec3(0, 1, 0))};
        head.show(turned);
        EXPECT_FALSE(head.is_followed()) << yaw_rad;
        EXPECT_EQ(head.around().orientation, turned.orientation) << yaw_rad;
        head.sent({turned.position_m, turned.orientation * glm::angleAxis(0.05, glm::dvec3(1, 0, 0))});
    }
}

/// A server from before heads said that they only turn.
TEST(FollowedHead, DoesNotAddUpTurnsThatAnOlderServerRendersFrom) {
    FollowedHead head;
    const Pose turned = {at(1).position_m, glm::angleAxis(0.3, glm::dvec3(0, 1, 0))};
    head.show(at(1));
    head.looked(at(1));
    head.looked(turned);
    head.show(turned);
    EXPECT_FALSE(head.is_followed());
    EXPECT_EQ(head.around().orientation, at(1).orientation);
    head.show(at(2));
    EXPECT_EQ(head.around().position_m, at(2).position_m) << "the scene's own path goes on";
}

/// Both signs of a quaternion are the same turn.
TEST(FollowedHead, KnowsItsOwnTurnOfEitherSign) {
    FollowedHead head;
    const glm::dquat turn = glm::angleAxis(0.3, glm::dvec3(0, 1, 0));
    head.show(at(1));
    head.sent({at(1).position_m, turn});
    head.show({at(1).position_m, -turn});
    EXPECT_TRUE(head.is_followed());
    EXPECT_EQ(head.around().orientation, at(1).orientation);
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
