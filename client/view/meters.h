#pragma once
/// How much of something a second has, of late. No wall clock: callers say what time it is.
#include <deque>
#include <utility>

namespace equistream {

class Meter {
public:
    explicit Meter(double window_s) : window_s_(window_s) {}

    /// Times ascend.
    void add(double now_s, double amount);
    double per_second(double now_s);

private:
    void forget(double now_s);

    double window_s_, sum_ = 0;
    std::deque<std::pair<double, double>> amounts_;  ///< when, and how much
};

}  // namespace equistream
