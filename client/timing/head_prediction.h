#pragma once
/// Where a head will be when a refresh is seen, from the poses that were seen of it until now.
///
/// A parabola is fitted to the last 60 ms of poses, orientation as rotation from the newest pose and position apart.
/// What slows down goes on slowing until it rests, and never turns back; what speeds up goes on at the speed it has: a
/// head's surges are short, and acceleration extrapolated is what overshoots (Zikan et al. 1995, "Note on dynamics of
/// human head motions and on predictive filtering of head-set orientations", found first-order predictions of
/// orientation better than second-order ones). Chosen by measurement among it, hold, constant velocity, damped
/// velocity, double exponential smoothing (LaViola 2003) and a constant-acceleration Kalman filter, on generated motion
/// of seated viewers (head_prediction_test.cpp): root mean square error in degrees at peak rates of 100 to 200
/// degrees/s, poses at 90 Hz with 0.02 degrees of noise,
///
///     ms ahead                      10     20     50    100
///     hold                        0.56   1.13   2.80   5.54
///     constant velocity           0.09   0.16   0.58   1.87
///     Kalman, its noise known     0.07   0.13   0.46   1.70
///     this                        0.07   0.12   0.43   1.45
///
/// Where a turn of minimum jerk ends it overshoots by at most a tenth of what constant velocity does up to 50 ms ahead,
/// by two thirds at 100 ms. Exact for turns at a constant rate about any one axis and for positions at constant
/// velocity. No allocation; one thread.
#include <equistream/camera.h>

#include <array>
#include <cstddef>

namespace equistream {

class HeadPredictor {
public:
    /// A pose of the head, in any rhythm. One at the time of the last one replaces it; earlier ones are ignored. Of
    /// those that are 180 ms older than the newest, none counts.
    void seen(double time_s, const Pose& head);
    bool has_seen() const { return count_ > 0; }
    /// At a later time; further ahead than 150 ms, as then. At least one pose must have been seen.
    Pose predict(double time_s) const;

private:
    struct Seen {
        double time_s = 0;
        Pose head;
    };
    const Seen& ago(std::size_t poses) const { return seen_[(count_ - 1 - poses) % seen_.size()]; }

    std::array<Seen, 64> seen_{};  ///< 60 ms at 1 kHz
    std::size_t count_ = 0;        ///< ever
};

}  // namespace equistream
