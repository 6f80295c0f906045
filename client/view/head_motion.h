#pragma once
/// Where the viewer's head is, as it is steered, and where it will be when a refresh is seen.
#include "keys.h"

#include <equistream/camera.h>

#include <client/playback/playback.h>
#include <client/timing/head_prediction.h>

#include <bitset>
#include <optional>
#include <string>

namespace equistream {

// Where the viewer's head is: turned and moved by keys, mouse and gamepad around where the frame's own head was,
// inside its head box and beyond. No wall clock: callers say how much time went by.

/// What pushes the head now. Held actions, and sticks from -1 to 1; drags in radians.
struct Steering {
    std::bitset<std::size_t(last_held_action) + 1> held;
    double turn_x = 0, turn_y = 0;                ///< right and down
    double move_x = 0, move_y = 0, move_z = 0;    ///< right, up and back
    double drag_yaw_rad = 0, drag_pitch_rad = 0;  ///< left and up

    bool is_held(Action action) const { return held[std::size_t(action)]; }
};

class Navigator {
public:
    static constexpr double turn_rad_per_s = 1.0;
    static constexpr double move_m_per_s = 0.15;
    /// It takes this long to be at full speed, so that a tap is a small step.
    static constexpr double soft_start_s = 0.25;

    void steer(const Steering& steering, double seconds);
    void centre();

    double yaw_rad() const { return yaw_rad_; }      ///< left is positive
    double pitch_rad() const { return pitch_rad_; }  ///< up is positive; at most straight up or down
    /// From where the frame's head is, in that head's axes.
    glm::dvec3 offset_m() const { return offset_m_; }
    /// In the world, for a frame whose head is `around`: turning a head about its own up, then tilting it.
    Pose head(const Pose& around) const;

private:
    double yaw_rad_ = 0, pitch_rad_ = 0;
    glm::dvec3 offset_m_{0};
    glm::dvec3 push_{0};  ///< sideways, up, back: from -1 to 1, softened
};

/// How far eyes beyond the head box make the picture fade: 0 within it, 1 from half a radius outside on, and from 25 cm
/// where that is more.
double head_box_fading(double distance_m, double box_radius_m);

// Where the viewer's head is, as it is steered, and where it will be when a refresh is seen. Poses are in the axes of
// the head that the frame was made for, so that a frame that comes is no motion. No wall clock; one thread.

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
    /// At once where the other one's head is, whose times are on another clock.
    void look_as(const HeadMotion& other) { navigator_ = other.navigator_; }

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
