#include "head_prediction.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace equistream {

namespace {

constexpr double window_s = 0.06, longest_ago_s = 0.18, furthest_ahead_s = 0.15;
constexpr double same_time_s = 1e-4;
/// Fewer poses determine no parabola; slow trackers may have them further back than the window.
constexpr std::size_t fewest_poses = 3;

glm::dvec3 rotation_vector(glm::dquat q) {
    if (q.w < 0)
        q = -q;
    const glm::dvec3 v(q.x, q.y, q.z);
    const double sine = glm::length(v);
    return sine < 1e-12 ? 2.0 * v : v * (2 * std::atan2(sine, q.w) / sine);
}

glm::dquat rotation_by(const glm::dvec3& vector) {
    const double angle = glm::length(vector);
    return angle < 1e-12 ? glm::dquat(1, 0, 0, 0) : glm::angleAxis(angle, vector / angle);
}

/// Least squares of y = c0 + c1 t + c2 t^2 for vectors; a straight line as long as there are two samples.
class Parabola {
public:
    void add(double t, const glm::dvec3& y) {
        double power = 1;
        for (std::size_t i = 0; i < t_.size(); ++i, power *= t) {
            t_[i] += power;
            if (i < y_.size())
                y_[i] += power * y;
        }
    }

    /// Of what moves so and slows down until it rests, after `ahead_s`.
    glm::dvec3 braked(double ahead_s) const {
        glm::dvec3 start, velocity, half_acceleration(0);
        if (t_[0] < fewest_poses) {
            const double determinant = t_[0] * t_[2] - t_[1] * t_[1];
            start = (t_[2] * y_[0] - t_[1] * y_[1]) / determinant;
            velocity = (t_[0] * y_[1] - t_[1] * y_[0]) / determinant;
        } else {
            const glm::dmat3 normal(t_[0], t_[1], t_[2], t_[1], t_[2], t_[3], t_[2], t_[3], t_[4]);
            const glm::dmat3 solved = glm::dmat3(y_[0], y_[1], y_[2]) * glm::inverse(normal);
            start = solved[0], velocity = solved[1], half_acceleration = solved[2];
        }
        const double speed = glm::length(velocity);
        if (speed < 1e-9)
            return start;
        const double braking = std::max(0.0, -2 * glm::dot(half_acceleration, velocity) / speed);
        const double moving_s = ahead_s * braking > speed ? speed / braking : ahead_s;
        return start + velocity / speed * (moving_s * (speed - braking * moving_s / 2));
    }

private:
    std::array<double, 5> t_{};  ///< sums of powers
    std::array<glm::dvec3, 3> y_{glm::dvec3(0), glm::dvec3(0), glm::dvec3(0)};
};

}  // namespace

void HeadPredictor::seen(double time_s, const Pose& head) {
    if (count_ > 0) {
        const double since_s = time_s - ago(0).time_s;
        if (since_s < -same_time_s)
            return;
        if (since_s < same_time_s)
            --count_;
    }
    seen_[count_ % seen_.size()] = {time_s, head};
    ++count_;
}

Pose HeadPredictor::predict(double time_s) const {
    assert(has_seen());
    const Seen& newest = ago(0);
    Parabola turn, move;
    std::size_t poses = 0;
    for (; poses < std::min(count_, seen_.size()); ++poses) {
        const Seen& one = ago(poses);
        const double t = one.time_s - newest.time_s;
        if (t < -longest_ago_s || (t < -window_s && poses >= fewest_poses))
            break;
        turn.add(t, rotation_vector(one.head.orientation * glm::conjugate(newest.head.orientation)));
        move.add(t, one.head.position_m - newest.head.position_m);
    }
    if (poses < 2)
        return newest.head;
    const double ahead_s = std::clamp(time_s - newest.time_s, 0.0, furthest_ahead_s);
    return {newest.head.position_m + move.braked(ahead_s),
            glm::normalize(rotation_by(turn.braked(ahead_s)) * newest.head.orientation)};
}

}  // namespace equistream
