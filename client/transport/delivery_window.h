#pragma once
/// The most bytes that may be on their way at once: twice the delivery rate times the delay of acknowledgements. It is
/// found from what the other end acknowledges and not from what is lost: a line that loses packets is no slower, one
/// with less room is (after Cardwell et al.: BBR: congestion-based congestion control, ACM Queue 14(5), 2016). Unlike
/// BBR's round trip, the delay runs until all earlier bytes have come too: packets may overtake each other.
#include <cstddef>
#include <deque>

namespace equistream {

/// Times in seconds of one clock that does not go back.
class DeliveryWindow {
public:
    /// Every 5 ms or so while something is not acknowledged: all bytes so far that were written, and of these the ones
    /// that were acknowledged. `line_is_full`: something waited to be written since the last call.
    void add(double time_s, double written_bytes, double delivered_bytes, bool line_is_full);

    /// The most that need not be acknowledged yet.
    std::size_t bytes() const;
    /// The highest of the last second in which the line was full; 0: not known yet.
    double bytes_per_second() const { return fastest_.empty() ? 0 : fastest_.front().value; }
    /// From when bytes are written to when they are acknowledged, where nothing else waits.
    double acknowledged_after_s() const;

private:
    struct Sample {
        double time_s, value;
    };

    void see_delay(double time_s, double delay_s);
    void see_rate(double time_s, double delivered_bytes, bool line_is_full);

    std::deque<Sample> written_, delivered_;
    double full_since_s_ = -1, rate_at_s_ = 0;     // -1: something more could have been written
    std::deque<Sample> fastest_;                   // the best comes first; each is better than all after it
    double shortest_s_ = -1, shortest_at_s_ = 0;   // -1: not known yet
    double drains_until_s_ = -1, drained_s_ = -1;  // so little is on its way that no queue is left; -1: it is not
};

}  // namespace equistream
