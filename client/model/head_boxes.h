#pragma once
/// Where eyes can be, and random points there.
#include <equistream/conventions.h>

#include <scenes/library/scene.h>

#include <glm/glm.hpp>

#include <cmath>
#include <random>
#include <span>
#include <vector>

namespace equistream {

// Random numbers that are the same with every standard library.

class Random {
public:
    explicit Random(std::uint64_t seed) : bits_(seed) {}

    double unit() { return double(bits_() >> 11) * 0x1p-53; }  ///< in [0, 1)
    glm::dvec3 on_sphere() {
        const double z = 2 * unit() - 1, angle = 2 * pi * unit(), r = std::sqrt(1 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
    }
    glm::dvec3 in_ball() { return on_sphere() * std::cbrt(unit()); }

private:
    std::mt19937_64 bits_;
};

// Where eyes can be: a ball around every point of a camera path. What a triangle may move there by the bound.

struct TriangleCorners {
    glm::vec3 a, b, c;
};

class HeadBoxes {
public:
    HeadBoxes(const PosePath& path, double radius_m);

    double radius_m() const { return radius_m_; }
    /// Points of the path no further apart than the radius, unless there would be more than 512.
    std::span<const glm::dvec3> centres() const { return centres_; }
    /// From the nearest centre to the nearest point of a triangle.
    double distance_m(const TriangleCorners& triangle) const;
    /// What the triangle may be displaced by, in metres: e (r - B) min(1, (r - B) cos t / B), the least over all
    /// centres, where cos t is taken from where in the ball the triangle is looked at a quarter of B from its plane.
    /// 0 where it reaches into a box. `distance_m` is distance_m(triangle).
    double allowed_m(const TriangleCorners& triangle, double distance_m, double error_rad) const;

    glm::dvec3 random_centre(Random& random) const;
    glm::dvec3 random_eye(Random& random) const { return random_centre(random) + radius_m_ * random.in_ball(); }

private:
    double radius_m_;
    std::vector<glm::dvec3> centres_;
};

}  // namespace equistream
