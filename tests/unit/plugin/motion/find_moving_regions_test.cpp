// Balls that move, spin, bend or rest in a room, seen by a camera that moves: their motion is known in closed form.
#include <plugin/motion/find_moving_regions.h>

#include <equistream/image_motion.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace equistream {
namespace {

constexpr double room_m = 5;

struct Ball {
    glm::dvec3 centre_m;
    double radius_m = 0;
    std::function<glm::dvec3(glm::dvec3 point_m, double seconds)> later;  ///< in the world
};

/// About the body's own centre, which moves.
Ball rigid_ball(glm::dvec3 centre_m, double radius_m, glm::dvec3 velocity_m_s, glm::dvec3 angular_rad_s) {
    return {centre_m, radius_m, [=](glm::dvec3 p, double t) {
                const double angle = glm::length(angular_rad_s) * t;
                const glm::dvec3 axis = angle == 0 ? glm::dvec3(0, 1, 0) : glm::normalize(angular_rad_s);
                return centre_m + velocity_m_s * t + glm::angleAxis(angle, axis) * (p - centre_m);
            }};
}

double hit_m(glm::dvec3 from, glm::dvec3 direction, glm::dvec3 centre, double radius) {
    const glm::dvec3 to = from - centre;
    const double b = glm::dot(to, direction), c = glm::dot(to, to) - radius * radius, d = b * b - c;
    if (d < 0)
        return INFINITY;
    const double near = -b - std::sqrt(d), far = -b + std::sqrt(d);
    return near > 0 ? near : far > 0 ? far : INFINITY;
}

struct Picture {
    EquirectCamera camera{480, 240, {}};
    Pose pose;
    FloatImage depth_m{480, 240, 1};
    IdImage id{480, 240, 1};
    struct Neighbour {
        Pose pose;
        double seconds = 0;
        FloatImage motion_px{480, 240, 2};
    };
    std::vector<Neighbour> neighbours;

    MotionPlanes planes(bool with_ids) const {
        MotionPlanes planes{camera, pose, depth_m.view(), {}, with_ids ? id.view() : ImageView<const std::uint32_t>{}};
        for (const Neighbour& neighbour : neighbours)
            planes.neighbours.push_back({neighbour.pose, neighbour.seconds, neighbour.motion_px.view()});
        return planes;
    }
    glm::dvec3 point_world(int x, int y) const {
        return pose.position_m + double(*depth_m.pixel(x, y)) * (pose.orientation * camera.direction(x + 0.5, y + 0.5));
    }
};

Picture look(const std::vector<Ball>& balls, const std::vector<double>& neighbours_s) {
    Picture p;
    p.pose = {{0.2, -0.1, 0.3}, glm::angleAxis(0.4, glm::dvec3(0, 1, 0))};
    for (const double seconds : neighbours_s)
        p.neighbours.push_back({{p.pose.position_m + glm::dvec3(0.9, 0.2, -0.6) * seconds,
                                 glm::angleAxis(0.4 + 1.1 * seconds, glm::normalize(glm::dvec3(0.2, 1, 0)))},
                                seconds});
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 480; ++x) {
            const glm::dvec3 direction = p.pose.orientation * p.camera.direction(x + 0.5, y + 0.5);
            double nearest = hit_m(p.pose.position_m, direction, {0, 0, 0}, room_m);
            std::uint32_t id = 1;
            for (std::size_t i = 0; i < balls.size(); ++i)
                if (const double r = hit_m(p.pose.position_m, direction, balls[i].centre_m, balls[i].radius_m);
                    r < nearest) {
                    nearest = r;
                    id = std::uint32_t(i) + 2;
                }
            *p.depth_m.pixel(x, y) = float(nearest);
            *p.id.pixel(x, y) = id;
            const glm::dvec3 at = p.pose.position_m + nearest * direction;
            for (Picture::Neighbour& to : p.neighbours) {
                const glm::dvec3 later = id == 1 ? at : balls[id - 2].later(at, to.seconds);
                const glm::dvec3 d = glm::conjugate(to.pose.orientation) * (later - to.pose.position_m);
                const auto motion = equirect_motion<double>({x + 0.5, y + 0.5}, {d.x, d.y, d.z}, 480, 240, {});
                to.motion_px.pixel(x, y)[0] = float(motion.u);
                to.motion_px.pixel(x, y)[1] = float(motion.v);
            }
        }
    return p;
}

/// Mean and largest angle, seen from the camera, between where regions are carried to and where their points are.
struct Carried {
    double mean_rad = 0, max_rad = 0;
    std::int64_t pixels = 0, strangers = 0;
};
Carried carry(const Picture& p, const FoundMotion& found, const std::vector<Ball>& balls, double seconds) {
    Carried extrapolated;
    for (const MovingRegion& region : found.regions) {
        const RigidTransform movement = moved_by(region.motion, seconds);
        for (const PixelRun& run : region.runs)
            for (int x = run.begin; x < run.end; ++x) {
                const std::uint32_t id = *p.id.pixel(x, run.row);
                extrapolated.strangers += id == 1;
                ++extrapolated.pixels;
                if (id == 1)
                    continue;
                const glm::dvec3 at = p.point_world(x, run.row);
                const glm::dvec3 is = balls[id - 2].later(at, seconds) - p.pose.position_m;
                const glm::dvec3 shown = movement(at - p.pose.position_m);
                const double angle = std::atan2(glm::length(glm::cross(is, shown)), glm::dot(is, shown));
                extrapolated.mean_rad += angle;
                extrapolated.max_rad = std::max(extrapolated.max_rad, angle);
            }
    }
    extrapolated.mean_rad /= double(std::max<std::int64_t>(1, extrapolated.pixels - extrapolated.strangers));
    return extrapolated;
}

std::int64_t pixels_of(const Picture& p, std::uint32_t id) {
    return std::ranges::count(p.id.samples(), id);
}

const Ball spinning = rigid_ball({0.3, 0.4, -1.8}, 0.5, {0.8, -0.3, 0.4}, {0.4, 2.5, -0.8});
const Ball behind = rigid_ball({0.1, 0.1, 2.4}, 0.4, {-0.6, 0, 0.1}, {0, 0, 1.5});  // across the seam
constexpr double frame_s = 1.0 / 30;

const double budget_rad = error_budget_rad(default_focal_length_px);

TEST(FindMovingRegions, EachBallIsOneRegionThatStaysWithinTheBudgetUntilTheHorizon) {
    const std::vector<Ball> balls = {spinning, behind};
    const Picture p = look(balls, {-frame_s, frame_s});
    const FoundMotion found = find_moving_regions(p.planes(true));
    ASSERT_EQ(found.regions.size(), 2u);
    const Carried extrapolated = carry(p, found, balls, extrapolation_horizon_s);
    EXPECT_EQ(extrapolated.strangers, 0);
    EXPECT_EQ(extrapolated.pixels, pixels_of(p, 2) + pixels_of(p, 3));
    EXPECT_LE(extrapolated.max_rad, budget_rad);
    EXPECT_GT(found.mean_motion_rad, 100 * budget_rad);
    EXPECT_LE(found.p95_error_rad, budget_rad);
    EXPECT_LE(found.mean_error_rad, budget_rad);
}

TEST(FindMovingRegions, OneNeighbourTellsOfTheNextFrame) {
    const std::vector<Ball> balls = {spinning, behind};
    for (const double seconds : {frame_s, -frame_s}) {
        const Picture p = look(balls, {seconds});
        const FoundMotion found = find_moving_regions(p.planes(true));
        ASSERT_EQ(found.regions.size(), 2u);
        EXPECT_LE(carry(p, found, balls, seconds).max_rad, budget_rad / 6);
        // And, of what turns while it goes, not quite of the one on the other side.
        EXPECT_GT(carry(p, found, balls, -seconds).max_rad, budget_rad / 6);
    }
}

TEST(FindMovingRegions, WithoutIdsPiecesAreWhatMovesAlike) {
    const std::vector<Ball> balls = {spinning, behind};
    const Picture p = look(balls, {-frame_s, frame_s});
    const FoundMotion found = find_moving_regions(p.planes(false));
    EXPECT_LE(found.regions.size(), 8u);
    const Carried extrapolated = carry(p, found, balls, extrapolation_horizon_s);
    EXPECT_EQ(extrapolated.strangers, 0);
    EXPECT_GE(extrapolated.pixels, 9 * (pixels_of(p, 2) + pixels_of(p, 3)) / 10);
    EXPECT_LE(extrapolated.mean_rad, budget_rad);
}

TEST(FindMovingRegions, WhatOnlyTheCameraMovesIsNotSaid) {
    const Picture p = look({rigid_ball({0.3, 0.4, -1.8}, 0.5, {0, 0, 0}, {0, 0, 0})}, {-frame_s, frame_s});
    const FoundMotion found = find_moving_regions(p.planes(true));
    EXPECT_TRUE(found.regions.empty());
    EXPECT_EQ(found.moving_pixels, 0);
}

TEST(FindMovingRegions, TheBoundDecidesWhatIsWorthSaying) {
    // Seen across, at 1.6 m and more: at half the budget's speed, and at four times that.
    const double speed = error_budget_rad(default_focal_length_px) / extrapolation_horizon_s * 1.6;
    const auto found = [&](double times) {
        const Picture p =
            look({rigid_ball({0.3, 0.4, -1.8}, 0.5, {times * speed, 0, 0}, {0, 0, 0})}, {-frame_s, frame_s});
        return find_moving_regions(p.planes(true)).regions.size();
    };
    EXPECT_EQ(found(0.5), 0u);
    EXPECT_EQ(found(4), 1u);
}

TEST(FindMovingRegions, PixelsThatOneNeighbourDoesNotShowAreFittedByTheOthers) {
    const std::vector<Ball> balls = {spinning};
    Picture p = look(balls, {-frame_s, frame_s});
    int hidden = 0;
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 480; x += 3)
            if (*p.id.pixel(x, y) == 2) {
                p.neighbours[1].motion_px.pixel(x, y)[0] = NAN;
                ++hidden;
            }
    ASSERT_GT(hidden, 300);
    const FoundMotion found = find_moving_regions(p.planes(true));
    ASSERT_EQ(found.regions.size(), 1u);
    EXPECT_LE(carry(p, found, balls, extrapolation_horizon_s).max_rad, budget_rad);
    EXPECT_LE(found.p95_error_rad, budget_rad);
}

TEST(FindMovingRegions, NothingIsSaidOfWhatANeighbourHardlyShows) {
    for (const int shown : {0, 1, 3, 100}) {
        Picture p = look({spinning}, {-frame_s, frame_s});
        int left = shown;
        for (int y = 0; y < 240; ++y)
            for (int x = 0; x < 480; ++x)
                if (*p.id.pixel(x, y) == 2 && --left < 0)
                    p.neighbours[1].motion_px.pixel(x, y)[0] = NAN;
        ASSERT_LT(left, 0);
        EXPECT_TRUE(find_moving_regions(p.planes(true)).regions.empty()) << shown << " pixels";
    }
}

TEST(FindMovingRegions, ABodyThatBendsBecomesParts) {
    const Ball bending{{0.3, 0.4, -1.8}, 0.5, [](glm::dvec3 p, double t) {
                           return p + t * glm::dvec3(0.5 * std::sin(6 * p.y), 0.4 * std::cos(5 * p.x), 0);
                       }};
    const Picture p = look({bending}, {-frame_s, frame_s});
    const FoundMotion found = find_moving_regions(p.planes(true));
    EXPECT_GT(found.regions.size(), 4u);
    EXPECT_LT(found.mean_error_rad, 0.1 * found.mean_motion_rad);
    EXPECT_EQ(carry(p, found, {bending}, frame_s).strangers, 0);
    EXPECT_FALSE(moving_regions_problem(found.regions, 480, 240));
}

TEST(BodyMotion, ASpinningCentreGoesStraightOn) {
    // A body about (0, 0, -2) that goes to the right and turns a whole turn a second.
    const glm::dvec3 centre(0, 0, -2), velocity(1, 0, 0), turn(0, 2 * pi, 0);
    const BodyMotion motion{{velocity - glm::cross(turn, centre), turn}, {-glm::cross(turn, velocity), {0, 0, 0}}};
    for (const double t : {-0.3, 0.1, 0.25}) {
        const RigidTransform moved = moved_by(motion, t);
        EXPECT_LT(glm::distance(moved(centre), centre + t * velocity), 2e-3) << t;
        const glm::dvec3 rim(0.5, 0, -2),
            to = centre + t * velocity + glm::angleAxis(2 * pi * t, glm::dvec3(0, 1, 0)) * (rim - centre);
        EXPECT_LT(glm::distance(moved(rim), to), 2e-3) << t;
        EXPECT_LT(glm::distance(moved.inverse()(moved(rim)), rim), 1e-12);
    }
}

TEST(Twist, TheExponentialMapIsUndoneByItsLogarithm) {
    const Twist twists[] = {
        {{1, 2, 3}, {0, 0, 0}}, {{1, -2, 3}, {1e-7, 0, 0}}, {{0.3, 0, 2}, {1, -2, 0.5}}, {{0, 1, 0}, {0, 0, 3}}};
    for (const Twist& twist : twists)
        for (const double seconds : {0.01, 0.5, -0.7}) {
            const Twist back = twist_of(moved_by(twist, seconds), seconds);
            EXPECT_LT(glm::distance(back.velocity_m_s, twist.velocity_m_s), 1e-7);
            EXPECT_LT(glm::distance(back.angular_rad_s, twist.angular_rad_s), 1e-7);
        }
    // Once round an axis through (0, 0, -2): a quarter turn takes the origin to (2, 0, -2).
    const double turn = pi / 2;
    const glm::dvec3 to = moved_by(Twist{{0, 0, 0}, {0, -turn, 0}}, 1)(glm::dvec3(0, 0, 2)) + glm::dvec3(0, 0, -2);
    const RigidTransform screw =
        moved_by(Twist{glm::cross(glm::dvec3(0, 0, -2), glm::dvec3(0, -turn, 0)), {0, -turn, 0}}, 1);
    EXPECT_LT(glm::distance(screw(glm::dvec3(0)), to), 1e-12);
}

}  // namespace
}  // namespace equistream
