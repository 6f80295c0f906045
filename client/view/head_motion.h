#pragma once
/// Where the viewer's head is, as it is steered, and where it will be when a refresh is seen. Poses are in the axes of
/// the head that the frame was made for, so that a frame that comes is no motion. No wall clock; one thread.
#include "navigator.h"

#include <client/playback/head_pose.h>

#include <client/timing/head_prediction.h>

#include <optional>
#include <string>

namespace equistream {

/// From the last look at what steers to what is seen: on average over the last ten or so.
class DisplayLatency {
public:
    /// Of a refresh, from when what steers was read until the buffers were swapped.
    void measured(double seconds);
    double seconds() const { return seconds_; }

private:
    double seconds_ = 0;
    bool known_ = false;
};

class HeadMotion {
public:
    /// Goes on until `time_s`, which ascends, as `steering` says; its drags happened in between.
    void steer(const Steering& steering, double time_s);
    /// Back at once, which is no motion.
    void centre();

    const Navigator& navigator() const { return navigator_; }
    /// As it is.
    Pose head() const { return navigator_.head({}); }
    /// As it will be so long after the last steer(); exactly as it is once it has rested.
    Pose predict(double ahead_s) const;
    /// It has rested so long that nothing is foretold but that it stays.
    bool is_resting() const;

private:
    Navigator navigator_;
    HeadPredictor predictor_;
    std::optional<double> time_s_;
    double moved_s_ = 0;  ///< when it did last
};

/// Where it looks and where it is: "yaw 25 pitch -10 deg, head 10 5 -2 cm"; left and up are positive.
std::string in_words(const Pose& head);

}  // namespace equistream
