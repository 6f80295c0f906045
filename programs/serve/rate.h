#pragma once
/// How coarsely a live stream is coded, so that its bytes reach the viewer that steers as they are made, and stay
/// within a stated rate. Coarseness counts in steps of CRF, of which six halve the bytes, about. Times are in seconds,
/// from anywhere; no clock of its own.
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace equistream::serve {

/// How a viewer keeps up.
struct Delivery {
    std::int64_t bytes_arrived = 0;  ///< at it, ever; of a browser: at the web door
    double behind_s = 0;             ///< for so long the oldest bytes wait, or too many are under way
};

class RateControl {
public:
    /// `max_bps`: bits a second at most; nothing: what the line carries.
    explicit RateControl(std::optional<double> max_bps) : max_bps_(max_bps) {}

    /// A sphere has been coded, so much coarser than was asked for.
    void coded(double at_s, std::size_t bytes, double coarser, bool begins_group);
    /// The viewer that steers, whenever a sphere has been coded; another one begins anew.
    void delivered(double at_s, int viewer, const Delivery& delivery);

    /// Nobody watches for a while: what was coded and sent before says nothing of what comes.
    void pause();

    /// Steps of CRF beyond what was asked for, for the next sphere: 0 to coarsest.
    double coarser() const { return coarser_; }
    /// What the viewer's line is found to carry; nothing while all arrives as it is made.
    std::optional<double> line_bps() const { return line_bps_; }
    /// What the stream may take: only where coarser() is above 0.
    double limit_bps() const { return limit_bps_; }

    static constexpr double coarsest = 30;

private:
    struct Sphere {
        double at_s;
        double bits;  ///< as they would be if nothing were coded coarser
    };
    struct Sent {
        double at_s;
        std::int64_t bytes;
    };

    std::optional<double> carried_bps() const;
    void choose(double at_s);

    std::optional<double> max_bps_, line_bps_;
    std::deque<Sphere> spheres_;
    std::deque<Sent> sent_;
    int viewer_ = 0;
    double coarser_ = 0, limit_bps_ = 0;
    double line_changed_s_ = 0, chosen_s_ = 0;
    double key_excess_bits_ = 0;  ///< as they would be if nothing were coded coarser
};

/// So many steps of CRF halve the bytes, about, as half the pixels do.
inline constexpr double steps_that_halve = 6;

/// How often to halve the window's pixels (window.h). Each change costs a key frame, and key frames make a stream
/// coarser for a while: so pixels come back one halving at a time, after they could have for long.
class WindowHalvings {
public:
    /// `crf`: as asked for.
    explicit WindowHalvings(double crf) : crf_(crf) {}

    /// For the next sphere, which is so many steps of CRF coarser than was asked for.
    int next(double at_s, double coarser);

private:
    double crf_;
    int halvings_ = 0;
    std::optional<double> fewer_since_s_;  // that fewer would do
    std::optional<double> given_back_s_;   // when pixels last were
};

/// Of a window in a sphere the window is coded coarser first, the sphere around it last.
struct CoarserParts {
    double window = 0, base = 0;
};
CoarserParts divided(double coarser, bool has_window);

}  // namespace equistream::serve
