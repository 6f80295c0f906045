#include <programs/play/head_steering.h>

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace equistream::play {
namespace {

constexpr double speed_m_s = 0.3;

Pose on_path(double time_s) {
    return {{speed_m_s * time_s, std::sin(time_s), 0}, {1, 0, 0, 0}};
}

/// Makes a frame every so often, for the head that came last by then; what it made comes a while later.
class PacedServer {
public:
    PacedServer(double interval_s, double delay_s) : interval_s_(interval_s), delay_s_(delay_s) {}

    /// Heads of so many frames, by frame.
    std::vector<FrameInfo> steered(HeadSteering::Path path, int count, SteeringFigures* figures = nullptr) {
        std::vector<FrameInfo> made;
        Pose known{{9, 9, 9}, {1, 0, 0, 0}};
        HeadSteering steering(std::move(path), [&](const ViewerPose& pose) {
            under_way_.emplace_back(now_s_, pose.head);
            return true;
        });
        std::size_t come = 0;
        const auto come_before = [&](double time_s) {
            for (; come < made.size() && made[come].time_s + delay_s_ < time_s; ++come) {
                now_s_ = made[come].time_s + delay_s_;
                steering.came(made[come]);
            }
        };
        for (int frame = 0; frame < count; ++frame) {
            const double made_s = interval_s_ * frame;
            come_before(made_s);
            for (const auto& [sent_s, head] : under_way_)
                if (sent_s + travel_s < made_s)
                    known = head;
            made.emplace_back();
            made.back().time_s = made_s;
            made.back().head = known;
        }
        come_before(interval_s_ * count + delay_s_);
        if (figures != nullptr)
            *figures = steering.figures();
        return made;
    }

private:
    static constexpr double travel_s = 0.001;

    double interval_s_, delay_s_, now_s_ = 0;
    std::vector<std::pair<double, Pose>> under_way_;
};

double off_m(const FrameInfo& frame) {
    return glm::distance(frame.head.position_m, on_path(frame.time_s).position_m);
}

TEST(HeadSteering, FramesAreMadeForWhereTheHeadIsAtTheirTime) {
    for (const double delay_s : {0.05, 0.31, 0.93}) {
        SteeringFigures figures;
        const auto made = PacedServer(0.2, delay_s).steered(on_path, 40, &figures);
        const int settled = int(std::ceil(3 * (delay_s + 0.2) / 0.2));
        for (int i = settled; i < 40; ++i)
            EXPECT_LT(off_m(made[std::size_t(i)]), 1e-9) << "delay " << delay_s << ", frame " << i;
        EXPECT_GT(off_m(made[1]), 1e-3) << "nothing could be known yet";
        double late_s = 0;
        std::int64_t made_for_sent = 0;
        for (const FrameInfo& frame : made)
            if (frame.head.position_m.z == 0) {
                late_s += frame.time_s - frame.head.position_m.x / speed_m_s;
                ++made_for_sent;
            }
        EXPECT_EQ(figures.frames, made_for_sent);
        EXPECT_EQ(figures.heads_sent, 40);
        EXPECT_GT(figures.late_s, 0) << "of the first ones";
        EXPECT_NEAR(figures.late_s, late_s / double(made_for_sent), 1e-9);
    }
}

/// As far as it goes: heads of a path's end, or of somebody else, say nothing.
TEST(HeadSteering, AHeadThatRestsIsSentAndFollowed) {
    const Pose there{{1, 2, 3}, {1, 0, 0, 0}};
    const auto made = PacedServer(0.2, 0.3).steered([&](double) { return there; }, 10);
    EXPECT_EQ(made[0].head.position_m, glm::dvec3(9, 9, 9));
    for (std::size_t i = 4; i < made.size(); ++i)
        EXPECT_EQ(made[i].head.position_m, there.position_m);
}

TEST(HeadSteering, AServerThatFollowsNobodyIsToldAllTheSame) {
    int sent = 0;
    HeadSteering steering(on_path, [&](const ViewerPose& pose) {
        // Nothing says that the head would be late.
        EXPECT_EQ(pose.head.position_m, on_path(pose.time_s).position_m);
        ++sent;
        return true;
    });
    for (int i = 0; i < 1000; ++i) {
        FrameInfo frame;
        frame.time_s = 0.04 * i;
        frame.head.position_m = {-1, 0, 0};
        steering.came(frame);
    }
    EXPECT_EQ(sent, 1000);
    EXPECT_EQ(steering.figures().frames, 0);
    EXPECT_EQ(steering.figures().late_s, 0);
}

}  // namespace
}  // namespace equistream::play
