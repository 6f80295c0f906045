#include "fit_twist.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace equistream {
namespace {

constexpr int unknowns = 6;
constexpr int rounds = 6;
/// Of what points tell of an unknown on average: below it the rounding of motion planes speaks.
constexpr double min_told = 1e-6;

using Vector6 = std::array<double, unknowns>;

struct NormalEquations {
    std::array<Vector6, unknowns> matrix{};
    Vector6 right{};

    void add(const Vector6& row, double value) {
        for (int i = 0; i < unknowns; ++i) {
            for (int j = 0; j <= i; ++j)
                matrix[i][j] += row[i] * row[j];
            right[i] += row[i] * value;
        }
    }
    /// Translations and turns each get a floor under what is known of them.
    void hold_what_is_not_told() {
        for (const int first : {0, 3}) {
            const double mean =
                (matrix[first][first] + matrix[first + 1][first + 1] + matrix[first + 2][first + 2]) / 3;
            for (int i = first; i < first + 3; ++i)
                matrix[i][i] += min_told * mean + 1e-30;
        }
    }
    /// By Cholesky's decomposition: the matrix is symmetric and, with its floor, positive.
    Vector6 solve() const {
        std::array<Vector6, unknowns> l{};
        Vector6 x{};
        for (int i = 0; i < unknowns; ++i) {
            for (int j = 0; j <= i; ++j) {
                double sum = matrix[i][j];
                for (int k = 0; k < j; ++k)
                    sum -= l[i][k] * l[j][k];
                l[i][j] = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / l[j][j];
            }
            x[i] = right[i];
            for (int k = 0; k < i; ++k)
                x[i] -= l[i][k] * x[k];
            x[i] /= l[i][i];
        }
        for (int i = unknowns - 1; i >= 0; --i) {
            for (int k = i + 1; k < unknowns; ++k)
                x[i] -= l[k][i] * x[k];
            x[i] /= l[i][i];
        }
        return x;
    }
};

glm::dvec3 centre_of(std::span<const SeenPoint> points) {
    glm::dvec3 sum(0);
    for (const SeenPoint& point : points)
        sum += point.at_m;
    return sum / double(points.size());
}

}  // namespace

double angle_left_rad(const SeenPoint& point, const RigidTransform& movement, const glm::dvec3& offset_m) {
    const glm::dvec3 to = movement(point.at_m) - offset_m;
    return std::atan2(glm::length(glm::cross(to, point.seen)), glm::dot(to, point.seen));
}

RigidTransform fit_movement(std::span<const SeenPoint> points, const glm::dvec3& offset_m) {
    const glm::dvec3 centre = centre_of(points);
    RigidTransform movement;
    for (int round = 0; round < rounds; ++round) {
        const glm::dvec3 moved_centre = movement(centre);
        NormalEquations equations;
        for (const SeenPoint& point : points) {
            const glm::dvec3 at = movement(point.at_m);
            const glm::dvec3 to = at - offset_m;
            const double inverse_m = 1 / glm::length(to);
            // Two directions across the ray, in which what is left is an angle.
            const glm::dvec3 aside =
                glm::normalize(std::abs(point.seen.y) < 0.9 ? glm::cross(point.seen, glm::dvec3(0, 1, 0))
                                                            : glm::cross(point.seen, glm::dvec3(1, 0, 0)));
            for (const glm::dvec3& across : {aside, glm::cross(point.seen, aside)}) {
                const glm::dvec3 turn = glm::cross(at - moved_centre, across);
                equations.add({across.x * inverse_m, across.y * inverse_m, across.z * inverse_m, turn.x * inverse_m,
                               turn.y * inverse_m, turn.z * inverse_m},
                              -glm::dot(across, to) * inverse_m);
            }
        }
        equations.hold_what_is_not_told();
        const Vector6 step = equations.solve();
        // About the centre of the points, which keeps shift and turn apart.
        const RigidTransform turned = moved_by({{0, 0, 0}, {step[3], step[4], step[5]}}, 1);
        const glm::dvec3 shift(step[0], step[1], step[2]);
        movement = {turned.rotation * movement.rotation,
                    turned.rotation * (movement.translation_m - moved_centre) + moved_centre + shift};
    }
    return movement;
}

}  // namespace equistream
