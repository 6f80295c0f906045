#pragma once
/// Bytes that were written and that the other end has not acknowledged, and for how long. Where a line becomes narrow,
/// the system still takes what it took before, and all of that arrives before anything newer. A sender of pictures does
/// better to keep them, and to leave old ones out.
#include <cstddef>
#include <cstdint>
#include <deque>

namespace equistream {

/// As the system says it.
struct Unacknowledged {
    std::size_t bytes = 0;  ///< TLS's own among them
    double soonest_s = 0;   ///< the shortest time that an acknowledgement took so far; 0: not known
};

/// Times in seconds of one clock that does not go back.
class UnderWay {
public:
    static constexpr double between_looks_s = 0.02;

    /// Before something is written, and so often while anything is under way. `written`: all bytes so far.
    void see(double time_s, std::int64_t written, const Unacknowledged& unacknowledged);

    bool is_anything() const { return acknowledged_ < written_; }
    /// More would only wait, and may be left out once it is old: what is under way has been so for longer than a line
    /// that carries it would take.
    bool is_too_much(double time_s) const;
    /// Of what is under way the first bytes have been so for so long; 0: nothing is.
    double oldest_s(double time_s) const { return writes_.empty() ? 0 : time_s - writes_.front().time_s; }
    std::int64_t acknowledged() const { return acknowledged_; }

private:
    struct Written {
        double time_s;
        std::int64_t bytes;  // ever
    };

    std::deque<Written> writes_;  // not acknowledged yet
    std::int64_t written_ = 0, acknowledged_ = 0;
    double soonest_s_ = 0;
};

}  // namespace equistream
