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
    /// At least 8 centres, as many cells as meet in a corner of their grid.
    HeadBoxes(const PosePath& path, double radius_m, std::size_t max_centres = 512);

    double radius_m() const { return radius_m_; }
    /// Points no further apart than the radius, along the path. Where these would be too many: middles of the grid's
    /// cells that it comes through, in the order it does, so that laps count once.
    std::span<const glm::dvec3> centres() const { return centres_; }
    /// For each centre a point of the path near it: the first in its cell. A cell's middle may lie within a wall.
    std::span<const glm::dvec3> points_on_path() const { return on_path_; }
    /// A cell's side: the radius, or as much more as it takes to have few enough. 0 where there is no grid.
    double cell_m() const { return cell_m_; }
    /// By how much balls around centres are larger than head boxes, so that they hold all of them. Where cells are as
    /// wide as the radius it is 0, and rays alone check; beyond that about half a cell's diagonal at most.
    double added_m() const { return added_m_; }
    /// From the nearest centre to the nearest point of a triangle.
    double distance_m(const TriangleCorners& triangle) const;
    /// What the triangle may be displaced by, in metres: e (r - B) min(1, (r - B) cos t / B), the least over all
    /// centres, where cos t is taken from where in the ball the triangle is looked at a quarter of B from its plane.
    /// B is the radius and what is added to it. 0 where the triangle reaches into a ball. `distance_m` is
    /// distance_m(triangle).
    double allowed_m(const TriangleCorners& triangle, double distance_m, double error_rad) const;

    /// On the path itself, each length of it as likely. Where there is a grid, half of them are points_on_path, each as
    /// likely.
    glm::dvec3 random_centre(Random& random) const;
    glm::dvec3 random_eye(Random& random) const { return random_centre(random) + radius_m_ * random.in_ball(); }

private:
    void take_cells(std::size_t max_centres);

    double radius_m_, cell_m_ = 0, added_m_ = 0;
    std::vector<glm::dvec3> keys_;
    std::vector<double> along_m_;  // by key: the path's length up to it
    std::vector<glm::dvec3> centres_, on_path_;
};

}  // namespace equistream
