// Pencils of rays against closed forms, and against a second eye for which the ray to the same point is searched.
#include <equistream/virtual_image.h>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

namespace equistream {
namespace {

using Vector = Vector3<double>;
using Rays = Pencil<double>;

Vector own(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}
glm::dvec3 theirs(const Vector& v) {
    return {v.x, v.y, v.z};
}

constexpr Vector flat[Rays::count] = {};

/// A ball that mirrors; hit from outside.
struct Ball {
    glm::dvec3 centre;
    double radius;

    std::optional<double> distance(const glm::dvec3& origin, const glm::dvec3& direction) const {
        const glm::dvec3 to = origin - centre;
        const double b = glm::dot(to, direction), d = b * b - glm::dot(to, to) + radius * radius;
        return d < 0 ? std::nullopt : std::optional(-b - std::sqrt(d));
    }
    void mirror(Rays& rays, const glm::dvec3& at) const {
        const glm::dvec3 normal = (at - centre) / radius;
        rays.onto_surface(own(normal));
        Vector bend[Rays::count];
        for (int i = 0; i < Rays::count; ++i)
            bend[i] = scaled(rays.position[i], 1 / radius);
        rays.reflect(own(normal), bend);
    }
};

TEST(VirtualImage, a_plane_mirror_shows_the_mirror_image_however_it_stands) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> some(-1, 1);
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 d = glm::normalize(glm::dvec3(some(random), some(random), some(random)));
        glm::dvec3 n = glm::normalize(glm::dvec3(some(random), some(random), some(random)));
        if (glm::dot(n, d) > 0)
            n = -n;
        Rays rays = Rays::from_eye(own(d));
        rays.travel(2);
        rays.onto_surface(own(n));
        rays.reflect(own(n), flat);
        rays.travel(3.5);
        EXPECT_LT(glm::length(theirs(rays.direction) - glm::reflect(d, n)), 1e-14);
        EXPECT_NEAR(rays.image_distance(false), 5.5, 1e-10);
        EXPECT_TRUE(std::isinf(rays.image_distance(true)));
        const glm::dvec3 movement(some(random), some(random), some(random));
        EXPECT_LT(glm::length(theirs(rays.image_movement(own(d), 5.5, own(movement))) - glm::reflect(movement, n)),
                  1e-10);
    }
}

TEST(VirtualImage, a_ball_and_a_bowl_obey_the_mirror_equation) {
    const Vector d{0, 0, -1}, n{0, 0, 1};
    for (const double radius : {0.5, 2.0, -0.8, -3.0, -12.0})  // below 0: a bowl
        for (const double thing : {0.2, 1.0, 7.0}) {
            Rays rays = Rays::from_eye(d);
            rays.travel(2);
            rays.onto_surface(n);
            Vector bend[Rays::count];
            for (int i = 0; i < Rays::count; ++i)
                bend[i] = scaled(rays.position[i], 1 / radius);
            rays.reflect(n, bend);
            // Of the sky it is at the focus. What would be behind the eye is at infinity.
            const auto expect = [&](double found, double image) {
                if (image > 0)
                    EXPECT_NEAR(found, image, 1e-10) << radius << " " << thing;
                else
                    EXPECT_TRUE(std::isinf(found)) << radius << " " << thing;
            };
            expect(rays.image_distance(true), 2 + radius / 2);
            rays.travel(thing);
            expect(rays.image_distance(false), 2 + 1 / (2 / radius + 1 / thing));
        }
}

TEST(VirtualImage, a_slab_of_glass_brings_things_nearer) {
    Rays rays = Rays::from_eye({0, 0, -1});
    rays.travel(2);
    rays.refract({0, 0, 1}, flat, 1 / 1.5);
    rays.travel(0.6);
    rays.refract({0, 0, 1}, flat, 1.5);
    rays.travel(1);
    EXPECT_NEAR(rays.image_distance(false), 2 + 0.6 / 1.5 + 1, 1e-12);
    // Aslant the two directions differ: h cos^2 / (n cos'^3) in the plane of incidence, h / (n cos') across it.
    const double angle = 0.7, n = 1.5, inside = std::asin(std::sin(angle) / n);
    rays = Rays::from_eye({std::sin(angle), 0, -std::cos(angle)});
    rays.travel(2);
    rays.onto_surface({0, 0, 1});
    rays.refract({0, 0, 1}, flat, 1 / n);
    EXPECT_NEAR(rays.direction.x, std::sin(inside), 1e-12);
    rays.travel(0.6);
    rays.onto_surface({0, 0, 1});
    rays.refract({0, 0, 1}, flat, n);
    rays.travel(1);
    const double across = 3 + 0.6 / n;
    const double in_plane = 3 + 0.6 / n * std::pow(std::cos(angle) / std::cos(inside), 2);
    EXPECT_NEAR(rays.image_distance(false), 2 / (1 / across + 1 / in_plane), 1e-10);
}

/// Where the eye sees `thing` in the ball: the direction whose reflection passes through it, by Newton's method.
glm::dvec3 direction_to(const Ball& ball, const glm::dvec3& eye, const glm::dvec3& thing, glm::dvec3 start) {
    for (int step = 0; step < 40; ++step) {
        const auto t = ball.distance(eye, start);
        const glm::dvec3 at = eye + *t * start;
        Rays rays = Rays::from_eye(own(start));
        rays.travel(*t);
        ball.mirror(rays, at);
        const glm::dvec3 on = theirs(rays.direction);
        const double reach = glm::dot(thing - at, on);
        rays.travel(reach);
        const glm::dvec3 missing = thing - at - reach * on;
        // What moves the end by `missing` turns the ray as a moved thing does.
        const glm::dvec3 turned = theirs(rays.image_movement(own(start), 1, own(missing)));
        start = glm::normalize(start + turned - glm::dot(turned, start) * start);
    }
    return start;
}

TEST(VirtualImage, a_second_eye_sees_what_is_in_a_ball_where_the_image_is_said_to_be) {
    const Ball ball{{0.4, -0.2, -2}, 0.5};
    const glm::dvec3 eye(0), thing(1.5, 0.8, -0.5), direction = direction_to(ball, eye, thing, {0.2, 0, -1});
    const double t = *ball.distance(eye, direction);
    Rays rays = Rays::from_eye(own(direction));
    rays.travel(t);
    ball.mirror(rays, t * direction);
    rays.travel(glm::length(thing - t * direction));
    const double distance = rays.image_distance(false);
    EXPECT_GT(distance, t);
    EXPECT_LT(distance, t + 0.25) << "the image is within half the radius behind a ball";
    // Over all ways that an eye may move across, the shift that the one distance predicts misses least at it.
    const auto error_at = [&](double guess) {
        double sum = 0;
        for (int way = 0; way < 32; ++way) {
            const double a = 2 * std::acos(-1.0) * way / 32;
            const glm::dvec3 moved =
                1e-4 * (std::cos(a) * theirs(rays.across[0]) + std::sin(a) * theirs(rays.across[1]));
            const glm::dvec3 seen = direction_to(ball, moved, thing, direction);
            const glm::dvec3 predicted = glm::normalize(guess * direction - moved);
            sum += glm::dot(seen - predicted, seen - predicted);
        }
        return sum;
    };
    const double least = error_at(distance);
    EXPECT_LT(least, error_at(distance * 1.02));
    EXPECT_LT(least, error_at(distance * 0.98));
    EXPECT_LT(least, 0.02 * error_at(t)) << "far better than the ball's own distance";
}

}  // namespace
}  // namespace equistream
