#pragma once
/// A network that does not exist: when each frame would arrive, if ever. No wall clock and no sockets; the same on
/// every platform for the same seed, by a generator that is written down here, and what befalls a frame depends on no
/// draw for another, so that changing one condition leaves the others' draws as they were.
///
/// A frame is cut into packets of packet_bytes, which leave one after another at the link's bandwidth and take the
/// delay, with jitter of the frame's own on top, uniform from 0 to jitter_s. While the link stalls nothing leaves; what
/// is under way arrives. As a stream (TCP), each lost packet is sent again a round trip later (twice the delay, at
/// least shortest_round_trip_s), and frames arrive in order. As datagrams, a frame that lost a packet is lost, and
/// jitter may reorder frames. Or each frame arrives when one did that was sent over a real network (a trace).
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

struct NetworkStall {
    double at_s = 0;  ///< of the stream's time
    double lasts_s = 0;
};

/// Both on one clock: that of the frames' times.
struct TracedArrival {
    double sent_s = 0;  ///< as the frame's time says
    double arrival_s = 0;
};

struct NetworkConditions {
    double delay_s = 0;
    double jitter_s = 0;
    double loss = 0;           ///< share of packets, below 1
    double bandwidth_bps = 0;  ///< bits per second; 0: no limit
    bool datagrams = false;
    std::vector<NetworkStall> stalls{};
    std::uint64_t seed = 1;
    /// By when they were sent, ascending. Not empty: nothing else counts, and a frame that is not there is lost.
    std::vector<TracedArrival> trace{};
};

/// "delay=80,jitter=15,loss=0.01,stall=2:3,bandwidth=20,seed=1", by the table that network_help prints; empty: nothing
/// is late. Throws InputError naming `where`, what was expected and what was found.
NetworkConditions parse_network(const std::string& spec, const std::string& where);
/// One line for each key: "delay=MS        each packet takes so long ...".
std::string network_help();

/// What WebRTC and QUIC keep packets to.
inline constexpr std::int64_t packet_bytes = 1200;
inline constexpr double shortest_round_trip_s = 0.01;

class DeliverySimulator {
public:
    explicit DeliverySimulator(NetworkConditions conditions);

    /// In ascending order of `sent_s`. When it arrives; nothing: never.
    std::optional<double> send(double sent_s, std::int64_t bytes);
    /// Nothing that is yet to be sent, at `sent_s` or later, arrives earlier.
    double earliest_arrival_s(double sent_s) const;

private:
    std::optional<double> traced(double sent_s) const;
    double leaves_s(double from_s, double sending_s) const;
    int max_losses(std::int64_t packets) const;
    double uniform(std::uint64_t what, std::uint64_t which) const;

    NetworkConditions conditions_;
    std::uint64_t frame_ = 0;
    double link_free_s_;
    double last_arrival_s_;
};

}  // namespace equistream
